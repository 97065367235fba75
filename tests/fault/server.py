"""Programs that are called thousands of times, from one start each (server.c)."""
import contextlib
import os
import queue
import struct
import subprocess
import types

PATIENCE = 300


class Server:
    """One program that waits for requests; of one thread."""

    def __init__(self, program, library):
        answers, answer = os.pipe()
        request, requests = os.pipe()
        self.process = subprocess.Popen([program], stdin=subprocess.DEVNULL, pass_fds=(request, answer),
                                        env={**os.environ, "LD_BIND_NOW": "1", "LD_PRELOAD": library, "SURVEYMC_SERVER": f"{request},{answer}"})
        os.close(request)
        os.close(answer)
        self.requests, self.answers = open(requests, "wb"), open(answers, "rb")

    def __call__(self, command, folder, fault="", counts=""):
        """What subprocess.run() would give; TimeoutExpired if it does not end."""
        text = b"".join(os.fsencode(word) + b"\0" for word in (folder, fault, counts, *map(str, command)))
        self.requests.write(struct.pack("=II", len(text), PATIENCE) + text)
        self.requests.flush()
        status, *sizes = struct.unpack("=iII", self.answers.read(12))
        out, err = (self.answers.read(size).decode(errors="replace") for size in sizes)
        if status == -1:
            raise subprocess.TimeoutExpired(command, PATIENCE)
        return types.SimpleNamespace(returncode=os.waitstatus_to_exitcode(status), stdout=out, stderr=err)

    def close(self):
        self.requests.close()
        self.process.wait()
        self.answers.close()


class Servers:
    """Servers of several programs, for several threads."""

    def __init__(self, library):
        self.library, self.free, self.all = library, {}, []

    def __call__(self, command, folder, fault="", counts=""):
        free = self.free.setdefault(command[0], queue.SimpleQueue())
        try:
            server = free.get_nowait()
        except queue.Empty:
            server = Server(command[0], self.library)
            self.all.append(server)
        try:
            return server(command, folder, fault, counts)
        finally:
            free.put(server)

    def close(self):
        for server in self.all:
            with contextlib.suppress(OSError):
                server.close()
