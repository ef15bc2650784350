# PYTHON_ARGCOMPLETE_OK
"""`mmt-drake`, the one program: finds the command, runs it, and tells every error in one line.

examples:
  mmt-drake demo
  mmt-drake run setup1 --record out.mcap
  mmt-drake run setup1 --operator hand.csv --set estimator.equations=without_d --seconds 20
  mmt-drake convert out.mcap out.csv

Exit status: 0 done, 2 bad input (one line says which), 130 interrupted.
`mmt-drake COMMAND --help` has examples for each command.
"""

import _thread
import argparse
import atexit
import gc
import importlib
import io
import os
import shlex
import sys
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from typing import Any, NamedTuple, NoReturn

from mmt_drake import __version__
from mmt_drake.errors import MmtError, printable


class Command(NamedTuple):
    """One command of the program.

    Its module has a docstring, which below its first line is the end of the command's help, `add_arguments(parser)` and
    `main(arguments) -> exit status`; it is imported when the command is used, so that help for all comes at once.
    """

    module: str
    help: str


COMMANDS = {
    "demo": Command("demo", "the main job end to end, from a shipped operator recording, on one page"),
    "run": Command("run_options", "build the diagram that a scenario describes and run it"),
    "experiment": Command("experiment", "the thesis's experiments: figures drawn, numbers printed"),
    "diagnose": Command("diagnose", "what physics a model leaves out that recordings show"),
    "trial": Command("trial", "the proof: concealed effects and real recordings, diagnosed and scored"),
    "fit": Command("fit", "a first model, from recordings alone"),
    "init": Command("init", "look at a file of one's own; write what its columns are, and a model to start from"),
    "excite": Command("excite", "a motion that tells a robot arm's inertial numbers, within its joints' limits"),
    "simulate": Command("simulate", "replay a recording's probe motion through a model file"),
    "view": Command("view", "play, scrub and loop a recording in the live view"),
    "join": Command("join", "one recording of the two sides of a run on two machines"),
    "convert": Command("convert", "any recording into any other"),
    "effects": Command("effects", "the library of effects that a model may have left out"),
    "doctor": Command("doctor", "what is installed and connected, and what to do about each gap"),
    "bench": Command("bench", "the performance figures, measured here and now"),
}

BAD_INPUT = 2
INTERRUPTED = 130
_CLOSED_PIPE = 141  # as the shell tells of a program that SIGPIPE ended

atexit.register(gc.freeze)  # all goes with the process; to search it for cycles first takes 0.6 s


class UsageError(MmtError):
    """The command line itself is wrong."""


class Parser(argparse.ArgumentParser):
    """Tells in one line what is wrong with the command line; no option may be shortened."""

    def __init__(self, **settings: Any):
        super().__init__(allow_abbrev=False, **settings)

    def error(self, message: str) -> NoReturn:
        """Raise the error; argparse would print and exit.

        Raises:
            UsageError: always.
        """
        raise UsageError(f"{message} (see `{self.prog} --help`)")


def parser(command: str | None) -> argparse.ArgumentParser:
    """The program's parser, complete for one command and with no more than the names of all others."""
    text = argparse.RawDescriptionHelpFormatter
    top = Parser(
        prog="mmt-drake",
        description="Model-mediated teleoperation on Drake: feel a local model of a remote object.",
        epilog=_epilog(__doc__),
        formatter_class=text,
    )
    top.add_argument("--version", action="version", version=f"mmt-drake {__version__}")
    debug: dict[str, Any] = {
        "action": "store_true",
        "default": argparse.SUPPRESS,
        "help": "show the traceback of an error",
    }
    top.add_argument("--debug", **debug)
    below = top.add_subparsers(title="commands", dest="command", metavar="COMMAND", required=True)
    for name, (module, line) in COMMANDS.items():
        sub = below.add_parser(name, help=line, description=f"{line[0].upper()}{line[1:]}.", formatter_class=text)
        if name == command:
            code = importlib.import_module(f"mmt_drake.cli.{module}")
            sub.epilog = _epilog(code.__doc__)
            code.add_arguments(sub)
            sub.add_argument("--debug", **debug)
            sub.set_defaults(main=code.main)
    return top


def _epilog(documentation: str | None) -> str:
    """The part of a module's docstring below its first line."""
    return (documentation or "").partition("\n\n")[2].rstrip()


def main(argv: Sequence[str] | None = None) -> int:
    """Run the program.

    Args:
        argv: its arguments; those of the process by default.

    Returns:
        The exit status: 0, or what the command gives; 2 for bad input; 130 after Ctrl-C.
    """
    arguments = list(sys.argv[1:] if argv is None else argv)
    _open_streams()
    debug = "--debug" in arguments
    if "_ARGCOMPLETE" in os.environ:
        _complete()
    try:
        chosen = next((argument for argument in arguments if not argument.startswith("-")), None)
        try:
            parsed = parser(chosen).parse_args(arguments or ["--help"])
            parsed.command_line = shlex.join(["mmt-drake", *arguments])
        except SystemExit as done:  # after --help and --version
            sys.stdout.flush()
            return int(done.code or 0)
        with _interrupts_kept(), _own_code_named():
            status = int(parsed.main(parsed))
        sys.stdout.flush()
        return status
    except BrokenPipeError:
        _let_go()  # the reader has seen enough
        return _CLOSED_PIPE
    except KeyboardInterrupt as interrupt:
        known = str(interrupt)
        return _tell(f"interrupted; {known}" if known else "interrupted", INTERRUPTED)
    except MmtError as error:
        return _fail(error, str(error), debug)
    except MemoryError as error:
        return _fail(error, f"not enough memory: {error or 'for what was asked'}", debug)
    except ImportError as error:
        if isinstance(error.__cause__ or error.__context__, KeyboardInterrupt):  # so an extension tells it
            return _tell("interrupted", INTERRUPTED)
        raise
    except OSError as error:
        try:
            sys.stdout.flush()
        except OSError:
            _let_go()
        where = f"{error.filename}: " if error.filename else ""
        return _fail(error, f"{where}found {error.strerror or error}, expected a file to read or write", debug)


def _complete() -> None:
    """Tell a shell how the line may go on, and end (argcomplete)."""
    import argcomplete

    chosen = next((word for word in os.environ.get("COMP_LINE", "").split()[1:] if word in COMMANDS), None)
    argcomplete.autocomplete(parser(chosen))


@contextmanager
def _interrupts_kept() -> Iterator[None]:
    """Let Ctrl-C come again where it was lost: LLVM calls Python while it compiles, and drops what is raised there."""
    before = sys.unraisablehook

    def told(lost: Any) -> None:
        if lost.exc_type is not KeyboardInterrupt or threading.current_thread() is not threading.main_thread():
            return before(lost)
        again = threading.Timer(0.02, _thread.interrupt_main)  # out of the call that has just dropped it
        again.daemon = True
        again.start()

    sys.unraisablehook = told
    try:
        yield
    finally:
        sys.unraisablehook = before


@contextmanager
def _own_code_named() -> Iterator[None]:
    """As `mmt_drake.own_code.own_code_named`, which is not loaded before there is code of a person's own."""
    try:
        yield
    except Exception:
        from mmt_drake.own_code import own_code_named

        with own_code_named():
            raise


def _fail(error: Exception, line: str, debug: bool) -> int:
    if debug:
        raise error
    return _tell("; ".join([line, *getattr(error, "__notes__", ())]), BAD_INPUT)


def _tell(line: str, status: int) -> int:
    with suppress(OSError):  # nobody is there to read it
        print(printable(f"mmt-drake: {line}"), file=sys.stderr)
    return status


def _open_streams() -> None:
    """Send what the shell has closed nowhere (no file gets its number), and characters a stream has not as escapes."""
    for name, mode in (("stdin", "r"), ("stdout", "w"), ("stderr", "w")):
        if getattr(sys, name) is None:
            setattr(sys, name, os.fdopen(os.open(os.devnull, os.O_RDWR), mode))
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")


def _let_go() -> None:
    """Drop what is still buffered for standard output, which must not fail again when Python ends."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
