# SPDX-License-Identifier: Apache-2.0
"""`lce workbench`: runs, the misfit of a model, and the effect that it lacks, on a local web page."""

from __future__ import annotations

import argparse
import secrets
import socket
from pathlib import Path

from lce_app.cli.arguments import add_effect_files, check_inputs
from lce_app.workbench.quick_imports import quick_imports
from lce_data.errors import LceError

EXAMPLES = ("lce workbench runs --model m.yaml", "lce workbench session.zip")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of `lce workbench`."""
    parser.add_argument(
        "runs",
        nargs="*",
        type=Path,
        metavar="RUN | DIR | FILE.zip",
        help="runs, or the folder of them (default: runs, or this folder); the page sees nothing outside of it. Or a "
        "session that a page has exported: it is unpacked into a folder of its name",
    )
    parser.add_argument("--model", type=Path, metavar="M.yaml", help="model file to begin with")
    add_effect_files(parser)
    parser.add_argument("--port", type=int, default=8080, metavar="P", help="8080 by default; 0 takes a free one")
    parser.add_argument(
        "--host",
        default="127.0.0.1",
        metavar="ADDRESS",
        help="address to listen on; the URL printed carries a token without which nobody gets in",
    )
    parser.epilog = "What you decide, and the models, are kept in the folder `workbench` beside the runs."


def main(args: argparse.Namespace) -> int:
    """Serve the page until Ctrl-C."""
    check_inputs([*args.runs, *([args.model] if args.model else [])])
    from lce_app.workbench.archive import unpack
    from lce_app.workbench.session import folder_and_roles
    from lce_app.workbench.state import WorkbenchState

    paths = args.runs or [Path("runs") if Path("runs").is_dir() else Path()]
    if len(paths) == 1 and paths[0].suffix == ".zip":
        paths = [unpack(paths[0])]
    folder, chosen = folder_and_roles(paths)
    state = WorkbenchState(folder)
    state.session.make_place()
    state.read_early(chosen)
    with quick_imports():
        from lce_app.workbench import server
    port = _free_port(args.host, args.port)
    token = secrets.token_urlsafe(16)
    server.set_up(state, chosen, args.model)
    print(f"http://{_in_url(args.host)}:{port}/?token={token}   (Ctrl-C ends it)", flush=True)
    server.serve(args.host, port, token)
    if state.fatal_error:
        raise LceError(state.fatal_error)
    return 0


def _in_url(host: str) -> str:
    return f"[{host}]" if ":" in host else host


def _free_port(host: str, port: int) -> int:
    """The port, or for 0 one that is free. Raises LceError if the server could not listen there."""
    try:
        family = socket.AF_INET6 if ":" in host else socket.AF_INET
        with socket.create_server((host, port), family=family) as server:
            return int(server.getsockname()[1])
    except (OSError, OverflowError) as error:
        raise LceError(f"{host}:{port}: {error}; --port and --host choose another") from None
