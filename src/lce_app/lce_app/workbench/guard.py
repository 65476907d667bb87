# SPDX-License-Identifier: Apache-2.0
"""Who may talk to the server: whoever has the token; never the page of another site, nor a name that is not ours."""

from __future__ import annotations

import ipaddress
import re
import secrets
from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from typing import Any, Final
from urllib.parse import parse_qs

from starlette.applications import Starlette
from starlette.requests import cookie_parser

Scope = dict[str, Any]
Message = dict[str, Any]
Receive = Callable[[], Awaitable[Message]]
Send = Callable[[Message], Awaitable[None]]
App = Callable[[Scope, Receive, Send], Awaitable[None]]

COOKIE: Final = "lce_workbench"
POLICY: Final = (
    "default-src 'none'; script-src 'self' 'nonce-{nonce}' 'unsafe-eval'; style-src 'self' 'unsafe-inline'; "
    "connect-src 'self'; img-src 'self' data: blob:; font-src 'self'; frame-ancestors 'none'; form-action 'none'; "
    "base-uri 'none'"
)
"""Nothing is fetched from anywhere else, and no script runs but the server's own: neither one that a text smuggled into
the page nor one in an attribute. Vue compiles its templates on the page, hence unsafe-eval; Quasar sets styles."""
LOOPBACK: Final = ("localhost", "127.0.0.1", "[::1]")
"""Names of this machine that a browser may have in its address."""
_HOST: Final = re.compile(r"(?P<name>\[[0-9a-f:.]+\]|[a-z0-9._-]+)(:(?P<port>\d{1,5}))?", re.IGNORECASE)
_SCRIPT: Final = re.compile(rb"<script(?=[\s>])")


def is_loopback(host: str) -> bool:
    """Whether a name or an address is of this machine alone."""
    try:
        return host == "localhost" or ipaddress.ip_address(host.strip("[]")).is_loopback
    except ValueError:
        return False


def protect(app: Starlette, host: str, token: str) -> None:
    """Answer only who may talk to a server that listens on ``host``: whoever has the token.

    On loopback only names of this machine are answered, so that no foreign name can lead here (DNS rebinding).
    """
    names = frozenset((*LOOPBACK, host)) if is_loopback(host) else frozenset()
    app.add_middleware(Guard, token=token, names=names)


@dataclass(frozen=True)
class Refused(Exception):
    """A request that is not answered: the status, and why."""

    status: int
    why: str


class Guard:
    """ASGI middleware that refuses a request without the token, to another name, or from the page of another site.

    The token is expected once, in the address, and then kept as a cookie, one for each port. The server answers under
    ``names`` only; without any, under every name. Answers carry a Content-Security-Policy.
    """

    def __init__(self, app: App, token: str, names: frozenset[str] = frozenset()) -> None:
        self._app = app
        self._token = token
        self._names = names

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer 400 what is malformed and 403 who may not, or pass on."""
        if scope["type"] not in ("http", "websocket"):
            await self._app(scope, receive, send)
            return
        try:
            cookie = self._admitted(scope)
        except Refused as refused:
            await _refuse(scope, receive, send, refused)
            return
        await self._app(scope, receive, _Answer(send, cookie).send)

    def _admitted(self, scope: Scope) -> str:
        """The cookie to set, "" for none. Raises Refused."""
        headers = [(key.decode("latin-1").lower(), value.decode("latin-1")) for key, value in scope["headers"]]
        hosts = [value for key, value in headers if key == "host"]
        host = _HOST.fullmatch(hosts[0]) if len(hosts) == 1 else None
        if host is None:
            raise Refused(400, "The request names no host.")
        if self._names and host["name"].lower() not in self._names:
            raise Refused(403, "This workbench is for the machine that it runs on.")
        ours = (f"http://{host[0]}".lower(), f"https://{host[0]}".lower())  # https: behind a proxy
        if any(key == "origin" and value.lower() not in ours for key, value in headers):
            raise Refused(403, "The page of another site may not ask this.")
        name = f"{COOKIE}_{host['port'] or 80}"
        asked = parse_qs(scope.get("query_string", b"").decode("latin-1")).get("token", [""])[0]
        kept = [cookie_parser(value).get(name, "") for key, value in headers if key == "cookie"]
        if self._is_token(asked):
            return f"{name}={self._token}; HttpOnly; SameSite=Strict; Path=/"
        if not any(map(self._is_token, kept)):
            raise Refused(403, "The address lacks the token: open the one that lce workbench printed.")
        return ""

    def _is_token(self, given: str) -> bool:
        return secrets.compare_digest(given.encode(errors="replace"), self._token.encode())


class _Answer:
    """An answer on its way, with headers of ours; a page waits for its end, because its scripts get the nonce."""

    def __init__(self, send: Send, cookie: str) -> None:
        self._pass_on, self._cookie = send, cookie
        self._nonce = secrets.token_urlsafe(16)
        self._start: Message | None = None
        self._body = b""

    async def send(self, message: Message) -> None:
        """Pass a message on, or keep it until the page is whole."""
        if message["type"] == "http.response.start":
            message["headers"] = [*message["headers"], *self._headers()]
            if any(key.lower() == b"content-type" and b"html" in value for key, value in message["headers"]):
                self._start = message
                return
        elif self._start is not None and message["type"] == "http.response.body":
            self._body += message.get("body", b"")
            if message.get("more_body", False):
                return
            body = _SCRIPT.sub(b'<script nonce="%s"' % self._nonce.encode(), self._body)
            kept = [(key, value) for key, value in self._start["headers"] if key.lower() != b"content-length"]
            self._start["headers"] = [*kept, (b"content-length", b"%d" % len(body))]
            await self._pass_on(self._start)
            message = {**message, "body": body}
        await self._pass_on(message)

    def _headers(self) -> list[tuple[bytes, bytes]]:
        headers = [
            (b"content-security-policy", POLICY.format(nonce=self._nonce).encode()),
            (b"referrer-policy", b"no-referrer"),
            (b"x-content-type-options", b"nosniff"),
        ]
        return [*headers, (b"set-cookie", self._cookie.encode())] if self._cookie else headers


async def _refuse(scope: Scope, receive: Receive, send: Send, refused: Refused) -> None:
    if scope["type"] == "websocket":
        await receive()
        await send({"type": "websocket.close", "code": 1008})
        return
    headers = [(b"content-type", b"text/plain; charset=utf-8"), (b"x-content-type-options", b"nosniff")]
    await send({"type": "http.response.start", "status": refused.status, "headers": headers})
    await send({"type": "http.response.body", "body": f"{refused.why}\n".encode()})
