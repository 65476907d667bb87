# SPDX-License-Identifier: Apache-2.0
"""The page of the commands, from their argument parsers."""

import argparse

from lce_app.cli.main import COMMANDS, _parser, command_module

HEAD = """# Commands

Every command of `lce` with its options, as its parser states them; `lce COMMAND --help` shows the same.

Exit status: 0 done, 1 the data or the model cannot be used (one line says why), 2 wrong usage, 130 Ctrl-C.
"""
TAIL = """
Next: the [Python API](api.md) makes the same calls; the [file formats](formats.md) say what the files hold.
"""


def commands_page() -> str:
    """Usage, options and examples of every command."""
    index = [f"| [`lce {name}`](#lce-{name}) | {about} |" for name, about in COMMANDS.items()]
    texts = [HEAD, "| command | what it does |\n|---|---|", *index]
    return "\n".join([*texts, *(_command(name) for name in COMMANDS), TAIL])


def _command(name: str) -> str:
    parser = _subparser(name)
    parser.formatter_class = lambda prog: argparse.RawDescriptionHelpFormatter(prog, width=100)
    actions = [action for action in parser._actions if action.help != argparse.SUPPRESS and action.dest != "help"]
    rows = [f"| {_names(action)} | {_help(parser, action)} |" for action in actions]
    examples = "\n".join(command_module(name).EXAMPLES)
    about = parser.epilog.partition("examples:")[0].strip() if parser.epilog else ""
    return "\n".join(
        [
            f"\n## lce {name}\n",
            f"{COMMANDS[name][0].upper()}{COMMANDS[name][1:]}.\n",
            f"```text\n{parser.format_usage().strip()}\n```\n",
            "| argument | |\n|---|---|",
            *rows,
            f"\n```text\n{about}\n```" if about else "",
            f"\n```bash\n{examples}\n```",
        ]
    )


def _subparser(name: str) -> argparse.ArgumentParser:
    groups = [a for a in _parser([name])._actions if isinstance(a, argparse._SubParsersAction)]
    parser: argparse.ArgumentParser = groups[0].choices[name]
    return parser


def _names(action: argparse.Action) -> str:
    value = action.metavar or (action.dest.upper() if action.nargs != 0 else "")
    if action.choices is not None and action.metavar is None:
        value = "{" + ",".join(map(str, action.choices)) + "}"
    value = " ".join(value) if isinstance(value, tuple) else value
    names = ", ".join(action.option_strings) or str(value)
    text = f"{names} {value}".strip() if action.option_strings and action.nargs != 0 else names
    return f"`{text}`".replace("|", "\\|")


def _help(parser: argparse.ArgumentParser, action: argparse.Action) -> str:
    values = {**vars(action), "prog": parser.prog}
    return ((action.help or "") % values).replace("|", "\\|").replace("<", "&lt;")
