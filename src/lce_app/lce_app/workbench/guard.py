# SPDX-License-Identifier: Apache-2.0
"""Who may talk to the server: this machine, or whoever has the token; pages of other sites never."""

from __future__ import annotations

import ipaddress
import secrets
from collections.abc import Awaitable, Callable
from http.cookies import SimpleCookie
from typing import Any, Final
from urllib.parse import parse_qs, urlsplit

from starlette.applications import Starlette
from starlette.middleware.trustedhost import TrustedHostMiddleware

Scope = dict[str, Any]
Receive = Callable[[], Awaitable[dict[str, Any]]]
Send = Callable[[dict[str, Any]], Awaitable[None]]
App = Callable[[Scope, Receive, Send], Awaitable[None]]

COOKIE: Final = "lce_workbench"
POLICY: Final = (
    "default-src 'self'; script-src 'self' 'unsafe-inline' 'unsafe-eval'; style-src 'self' 'unsafe-inline'; "
    "img-src 'self' data: blob:; font-src 'self' data:; frame-ancestors 'none'; form-action 'none'; base-uri 'none'"
)
"""Nothing is fetched from anywhere else. Vue compiles its templates on the page, hence unsafe-eval."""


LOOPBACK: Final = ("localhost", "127.0.0.1", "[::1]")
"""Names of this machine that a browser may have in its address."""


def is_loopback(host: str) -> bool:
    """Whether a name or an address is of this machine alone."""
    try:
        return host == "localhost" or ipaddress.ip_address(host.strip("[]")).is_loopback
    except ValueError:
        return False


def protect(app: Starlette, host: str, token: str) -> None:
    """Answer only who may talk to a server that listens on ``host``: whoever has the token, if there is one.

    Without a token only names of this machine are answered, so that no foreign name can lead here (DNS rebinding).
    """
    app.add_middleware(Guard, token=token)
    if not token:
        app.add_middleware(TrustedHostMiddleware, allowed_hosts=[*LOOPBACK, host], www_redirect=False)


class Guard:
    """ASGI middleware that refuses a request from the page of another site, and one without the token if there is one.

    The token is expected once, in the address, and then kept as a cookie.
    """

    def __init__(self, app: App, token: str = "") -> None:
        self._app = app
        self._token = token

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer 403, or pass on."""
        if scope["type"] not in ("http", "websocket"):
            await self._app(scope, receive, send)
            return
        headers = {key.decode("latin-1").lower(): value.decode("latin-1") for key, value in scope["headers"]}
        if not (self._same_site(headers) and self._has_token(scope, headers)):
            await _refuse(scope, receive, send)
            return

        async def with_headers(message: dict[str, Any]) -> None:
            if message["type"] == "http.response.start":
                message["headers"] = [*message["headers"], *self._headers(scope)]
            await send(message)

        await self._app(scope, receive, with_headers)

    def _same_site(self, headers: dict[str, str]) -> bool:
        origin = headers.get("origin")
        return origin is None or urlsplit(origin).netloc == headers.get("host")

    def _has_token(self, scope: Scope, headers: dict[str, str]) -> bool:
        if not self._token:
            return True
        cookie = SimpleCookie(headers.get("cookie", "")).get(COOKIE)
        return any(
            secrets.compare_digest(given, self._token) for given in (_asked(scope), cookie.value if cookie else "")
        )

    def _headers(self, scope: Scope) -> list[tuple[bytes, bytes]]:
        headers = [
            (b"content-security-policy", POLICY.encode()),
            (b"referrer-policy", b"no-referrer"),
            (b"x-content-type-options", b"nosniff"),
        ]
        if self._token and _asked(scope) == self._token:
            headers.append((b"set-cookie", f"{COOKIE}={self._token}; HttpOnly; SameSite=Strict; Path=/".encode()))
        return headers


def _asked(scope: Scope) -> str:
    """The token in the address."""
    return parse_qs(scope.get("query_string", b"").decode("latin-1")).get("token", [""])[0]


async def _refuse(scope: Scope, receive: Receive, send: Send) -> None:
    if scope["type"] == "websocket":
        await receive()
        await send({"type": "websocket.close", "code": 1008})
        return
    text = b"This workbench is for the machine that it runs on, or for whoever has its token.\n"
    await send({"type": "http.response.start", "status": 403, "headers": [(b"content-type", b"text/plain")]})
    await send({"type": "http.response.body", "body": text})
