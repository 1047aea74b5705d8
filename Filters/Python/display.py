# SPDX-License-Identifier: BSD-3-Clause
"""A display in memory for programs that draw where there is none: an X server (Xvfb) of its own per command.

    python3 display.py [--screen 1600x1200x24] COMMAND [ARGUMENT]...

xvfb-run, which does the same, waits for a signal of the server. Where that comes first, as on a busy machine, it waits for
ever; and two of them that start at once can pick the same number. Xvfb itself tells when it is ready.
"""
import contextlib
import os
import shutil
import signal
import subprocess
import sys
import tempfile


def _start(number, screen, authority):
    """The server once it is ready; or None, and what it said."""
    reading, writing = os.pipe()
    with tempfile.TemporaryFile() as log:
        # Without -noreset the server restarts, and refuses clients, each time its last client has gone.
        server = subprocess.Popen(
            ["Xvfb", ":%d" % number, "-displayfd", str(writing), "-screen", "0", screen, "-nolisten", "tcp", "-noreset",
             "-auth", authority], pass_fds=[writing], stdin=subprocess.DEVNULL, stdout=log, stderr=log)
        os.close(writing)
        with os.fdopen(reading) as file:
            if file.readline():
                return server, ""
        server.wait()
        log.seek(0)
        return None, log.read().decode(errors="replace").strip()


@contextlib.contextmanager
def display(screen="1600x1200x24"):
    """Runs an X server; gives the environment of its clients. OSError if there is no Xvfb or it does not start."""
    if shutil.which("Xvfb") is None:
        raise OSError("there is no Xvfb (Debian package xvfb)")
    with tempfile.TemporaryDirectory() as folder:
        # One cookie for any host and display: family 0xffff, no address, no number, name, value.
        authority = os.path.join(folder, "authority")
        name = b"MIT-MAGIC-COOKIE-1"
        with open(authority, "wb") as file:
            file.write(b"\xff\xff\0\0\0\0" + len(name).to_bytes(2, "big") + name + b"\0\x10" + os.urandom(16))
        # Not display 0, at which other programs look for a graphics card.
        first = 100 + os.getpid() % 400
        for number in range(first, first + 20):
            server, log = _start(number, screen, authority)
            if server:
                break
        else:
            raise OSError("Xvfb does not start: " + log)
        try:
            yield dict(os.environ, DISPLAY=":%d" % number, XAUTHORITY=authority)
        finally:
            server.terminate()
            server.wait()


def main(arguments):
    screen = "1600x1200x24"
    if arguments[:1] == ["--screen"]:
        screen, arguments = arguments[1], arguments[2:]
    if not arguments:
        print(__doc__, file=sys.stderr)
        return 2
    # Whoever stops this stops the server and the command, too.
    for number in (signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, lambda *_: sys.exit(128 + signal.SIGTERM))
    try:
        with display(screen) as environment:
            command = subprocess.Popen(arguments, env=environment)
            try:
                status = command.wait()
            finally:
                command.kill()
    except OSError as error:
        print("%s: %s" % (os.path.basename(sys.argv[0]), error), file=sys.stderr)
        return 127
    except KeyboardInterrupt:
        return 130
    # As a shell says it.
    return status if status >= 0 else 128 - status


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
