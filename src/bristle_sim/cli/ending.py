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

USUAL = {signal.SIGINT: signal.default_int_handler, signal.SIGTERM: signal.SIG_DFL}
"""Python's own handlers, which are replaced."""


@contextmanager
def ending_in_order() -> Iterator[None]:
    """Let SIGINT raise KeyboardInterrupt and SIGTERM SystemExit, where there is no other handler for them."""
    before, hook = {}, sys.unraisablehook
    if threading.current_thread() is threading.main_thread():
        for number, handler in USUAL.items():
            if signal.getsignal(number) is handler:
                before[number] = signal.signal(number, _end)
                sys.unraisablehook = _end_again
    try:
        yield
    finally:
        sys.unraisablehook = hook
        for number, handler in before.items():
            signal.signal(number, handler)


def _end(number: int, frame: FrameType | None) -> None:
    """Raise the exception that ends the work; later where the engine or the hook is calling, which would print and forget it."""
    while frame is not None:
        code = frame.f_code
        callback = (
            code.co_filename.endswith("_callbacks.py") or code.co_name.endswith("free") or code.co_name == "freebody"
        )
        in_hook = code.co_name == _end_again.__name__ and frame.f_globals is globals()
        if ("pymunk" in code.co_filename and callback) or in_hook:
            _try_again(number)
            return
        frame = frame.f_back
    if number == signal.SIGTERM:
        raise SystemExit(TERMINATED)
    raise KeyboardInterrupt


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
