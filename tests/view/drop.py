# SPDX-License-Identifier: Apache-2.0
"""Drops files on a window of X, as a file manager does (XDND, version 5).

    python3 drop.py WINDOW PATH...
"""

import ctypes
import ctypes.util
import pathlib
import sys
import time

CLIENT_MESSAGE, SELECTION_REQUEST, SELECTION_NOTIFY = 33, 30, 31
WAIT_S = 30

x11 = ctypes.CDLL(ctypes.util.find_library("X11"))
Event = ctypes.c_long * 24  # of XEvent; all members but the first are as wide
ulong, pointer = ctypes.c_ulong, ctypes.c_void_p
x11.XOpenDisplay.restype = pointer
for name, kinds in {
    "XDefaultRootWindow": [pointer],
    "XInternAtom": [pointer, ctypes.c_char_p, ctypes.c_int],
    "XCreateSimpleWindow": [pointer, ulong]
    + [ctypes.c_int] * 2
    + [ctypes.c_uint] * 3
    + [ulong] * 2,
}.items():
    getattr(x11, name).argtypes, getattr(x11, name).restype = kinds, ulong
for name, kinds in {
    "XSetSelectionOwner": [pointer, ulong, ulong, ulong],
    "XSendEvent": [pointer, ulong, ctypes.c_int, ctypes.c_long, pointer],
    "XChangeProperty": [pointer, ulong, ulong, ulong]
    + [ctypes.c_int] * 2
    + [ctypes.c_char_p, ctypes.c_int],
    "XPending": [pointer],
    "XNextEvent": [pointer, pointer],
    "XFlush": [pointer],
}.items():
    getattr(x11, name).argtypes = kinds


class Source:
    def __init__(self, target):
        self.display = x11.XOpenDisplay(None)
        root = x11.XDefaultRootWindow(self.display)
        self.window = x11.XCreateSimpleWindow(self.display, root, 0, 0, 1, 1, 0, 0, 0)
        self.target = target
        self.text = self.atom("text/uri-list")
        x11.XSetSelectionOwner(self.display, self.atom("XdndSelection"), self.window, 0)

    def atom(self, name):
        return x11.XInternAtom(self.display, name.encode(), 0)

    def send(self, window, values):
        event = Event(*values)
        x11.XSendEvent(self.display, window, 0, 0, event)
        x11.XFlush(self.display)

    def tell(self, kind, *data):
        head = [CLIENT_MESSAGE, 0, 1, 0, self.target, self.atom(kind), 32]
        self.send(self.target, head + [self.window, *data])

    def answer(self, event, uris):
        """Gives the list of files to who asks for it."""
        requestor, selection, target, place, when = event[5:10]
        x11.XChangeProperty(
            self.display, requestor, place, target, 8, 0, uris, len(uris)
        )
        head = [SELECTION_NOTIFY, 0, 1, 0]
        self.send(requestor, head + [requestor, selection, target, place, when])

    def wait(self, kind, uris):
        """Until the target says that; answers its questions meanwhile."""
        end, event = time.monotonic() + WAIT_S, Event()
        while time.monotonic() < end:
            if not x11.XPending(self.display):
                time.sleep(0.01)
                continue
            x11.XNextEvent(self.display, event)
            if event[0] & 0xFF == SELECTION_REQUEST:
                self.answer(event, uris)
            elif event[0] & 0xFF == CLIENT_MESSAGE and event[5] == self.atom(kind):
                return
        sys.exit(f"{kind} did not come")


def main():
    uris = "".join(f"{pathlib.Path(p).as_uri()}\r\n" for p in sys.argv[2:]).encode()
    source = Source(int(sys.argv[1]))
    source.tell("XdndEnter", 5 << 24, source.text)
    source.tell("XdndPosition", 0, 100 << 16 | 100, 0, source.atom("XdndActionCopy"))
    source.wait("XdndStatus", uris)
    source.tell("XdndDrop", 0, 0)
    source.wait("XdndFinished", uris)


if __name__ == "__main__":
    main()
