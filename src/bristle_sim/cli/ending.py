"""End long work in order on Ctrl-C and SIGTERM: by an exception that removes partial files and is not lost on its way."""

from __future__ import annotations

import _thread
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

TERMINATED = 143  # exit status of a shell whose command was ended by SIGTERM
LATER = 1e-3  # seconds after which a signal that came at a bad moment is tried again


@contextmanager
def ending_in_order() -> Iterator[None]:
    """Let SIGINT raise KeyboardInterrupt and SIGTERM SystemExit, where there is no other handler for them."""
    ours: list[signal.Signals] = []
    if threading.current_thread() is threading.main_thread():
        usual = {signal.SIGINT: signal.default_int_handler, signal.SIGTERM: signal.SIG_DFL}
        ours = [number for number, handler in usual.items() if signal.getsignal(number) is handler]
    before, hook = {number: signal.signal(number, _end) for number in ours}, sys.unraisablehook
    if ours:
        sys.unraisablehook = _end_again
    try:
        yield
    finally:
        sys.unraisablehook = hook
        for number, handler in before.items():
            signal.signal(number, handler)


def _end(number: int, frame: FrameType | None) -> None:
    """Raise what ends the work, but later if the engine or the hook is calling, which would print and forget it."""
    while frame is not None:
        if _called_by_engine(frame) or frame.f_code is _end_again.__code__:
            _try_again(number)
            return
        frame = frame.f_back
    if number == signal.SIGTERM:
        raise SystemExit(TERMINATED)
    raise KeyboardInterrupt


def _called_by_engine(frame: FrameType) -> bool:
    """Whether a function is one of pymunk's that C code calls: callbacks of a step, and those that free objects."""
    code = frame.f_code
    return "pymunk" in code.co_filename and (
        code.co_filename.endswith("_callbacks.py") or code.co_name.endswith("free") or code.co_name == "freebody"
    )


def _end_again(lost: sys.UnraisableHookArgs) -> None:
    """Repeat an end that was lost in a destructor or another callback; report anything else as usual."""
    if issubclass(lost.exc_type, KeyboardInterrupt):
        _try_again(signal.SIGINT)
    elif issubclass(lost.exc_type, SystemExit):
        _try_again(signal.SIGTERM)
    else:
        sys.__unraisablehook__(lost)


def _try_again(number: int) -> None:
    threading.Timer(LATER, _thread.interrupt_main, (number,)).start()
