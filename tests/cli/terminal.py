"""terminal.py COLUMNS RAW SCREEN COMMAND...: runs COMMAND on a terminal of so many columns. RAW is
what it wrote, SCREEN the lines that one saw in the end; both streams go there. Ends with its status, or 9
if a line that was meant to be written over reached the last column.

With SIGNAL=NAME:TEXT in the environment, it gets that signal when TEXT has come."""
import fcntl
import os
import pty
import re
import signal
import struct
import sys
import termios

TOKEN = re.compile(r"\x1b\[([0-9;]*)([a-zA-Z])|[\r\n]|[^\x1b\r\n]+|\x1b")


class Screen:
    """Lines of characters, as a terminal without wrapping would have them."""

    def __init__(self):
        self.lines, self.at, self.widest = [[]], 0, 0

    def put(self, text):
        line = self.lines[-1]
        for c in text:
            line.extend(" " * (self.at + 1 - len(line)))
            line[self.at] = c
            self.at += 1

    def feed(self, text):
        for token in TOKEN.finditer(text):
            word = token.group()
            if word == "\r":
                self.at = 0
            elif word == "\n":
                self.lines.append([])
            elif token.group(2) == "K":
                self.widest = max(self.widest, self.at)
                del self.lines[-1][self.at:]
            elif token.group(2) == "m":
                pass
            else:
                assert token.group(2) is None and word != "\x1b", "unknown sequence %r" % word
                self.put(word)

    def text(self):
        return "\n".join("".join(line) for line in self.lines)


def read_all(terminal, child, name, wanted):
    raw, sent = b"", not name
    while True:
        try:
            piece = os.read(terminal, 65536)
        except OSError:  # Linux: the other end is closed
            return raw
        if not piece:
            return raw
        raw += piece
        if not sent and wanted.encode() in raw:
            os.kill(child, getattr(signal, "SIG" + name))
            sent = True


columns, raw_path, screen_path, command = int(sys.argv[1]), sys.argv[2], sys.argv[3], sys.argv[4:]
name, _, wanted = os.environ.pop("SIGNAL", "").partition(":")
child, terminal = pty.fork()
if child == 0:
    fcntl.ioctl(1, termios.TIOCSWINSZ, struct.pack("HHHH", 24, columns, 0, 0))
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_DFL)
    os.execv(command[0], command)
raw = read_all(terminal, child, name, wanted)
status = os.waitpid(child, 0)[1]
screen = Screen()
screen.feed(raw.decode())
open(raw_path, "wb").write(raw)
open(screen_path, "w").write(screen.text())
if screen.widest >= columns:
    sys.exit(9)
sys.exit(128 + os.WTERMSIG(status) if os.WIFSIGNALED(status) else os.WEXITSTATUS(status))
