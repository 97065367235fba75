#!/usr/bin/python3
"""Hostile files, closed descriptors, little memory, other builds, other settings: test_hardening.py SURVEYMC_EXECUTABLE
LIBRARY_WITH_OTHER_FLOATING_POINT [unittest arguments]"""
import csv
import os
import re
import resource
import shlex
import shutil
import struct
import subprocess
import sys
import unittest
from pathlib import Path

import h5py
import numpy as np
import xxhash

from durability import BAD_INPUT, CANNOT_WRITE, DONE, INTERRUPTED, PATIENCE, Case, program_from_arguments

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "scripts"))
from surveymc import integrity  # noqa: E402

INTERNAL, NO_MACHINE = 70, 71
ABORTED = -6  # by LLVM's OpenMP: it says "OMP: Error #34: System unable to allocate necessary resources"
FLOATING_POINT = ""
ESCAPE = re.compile("[\x00-\x08\x0b-\x1f\x7f\x80-\x9f]")


def records(data):
    """[mark, body] of a journal or a part."""
    out, at = [], 0
    while at < len(data):
        size, = struct.unpack_from("<Q", data, at + 8)
        out.append((data[at:at + 8], data[at + 16:at + 16 + size]))
        at += 16 + size + 16
    return out


def sealed(mark, body):
    data = mark + struct.pack("<Q", len(body)) + body
    return data + xxhash.xxh3_128(data).digest()


def of_another_program(data, change):
    """The same records, as another program would have written them."""
    out = b""
    for mark, body in records(data):
        hash_size, = struct.unpack_from("<Q", body, 0)
        at = 8 + hash_size
        size, = struct.unpack_from("<Q", body, at)
        name = change(body[at + 8:at + 8 + size].decode()).encode()
        out += sealed(mark, body[:at] + struct.pack("<Q", len(name)) + name + body[at + 8 + size:])
    return out


def part_of_another_program(data, change):
    """The same part, as another program whose name is as long would have written it: head of 128 bytes, then records."""
    size, = struct.unpack_from("<Q", data, 136)
    body = data[144:144 + size]
    hash_size, = struct.unpack_from("<Q", body, 0)
    at = 8 + hash_size
    length, = struct.unpack_from("<Q", body, at)
    name = change(body[at + 8:at + 8 + length].decode()).encode()
    assert len(name) == length, name
    numerics = name[name.index(b"; numerics "):]
    run = xxhash.xxh3_128(body[:at] + struct.pack("<Q", len(numerics)) + numerics).digest()
    head = data[:16] + run + data[32:112]
    about = sealed(data[128:136], body[:at + 8] + name + body[at + 8 + length:])
    return head + xxhash.xxh3_128(head).digest() + about + data[144 + size + 16:]


def another_revision_as_long(name):
    return re.sub(r"\(([^)]*)\)", lambda m: "(" + "0" * len(m[1]) + ")", name, count=1)


def another_revision(name):
    changed = re.sub(r"\(([^)]*)\), (\S+) ", r"(0123456789ab), SomeCompiler ", name)
    assert changed != name, name
    return changed


def other_numerics(name):
    changed = re.sub(r"; numerics (\d+)", lambda m: f"; numerics {m[1][:-1]}{(int(m[1][-1]) + 1) % 10}", name)  # as long
    assert changed != name, name
    return changed


class Hardening(Case):
    RUN = ("run", "large.toml", "-o", "out.h5", "--checkpoint-seconds", "0.01")

    def small(self, name="small.h5"):
        self.call("run", "small.toml", "-o", name)
        return self.folder / name

    def interrupted(self):
        """A journal with something in it; it and the hash of the whole run."""
        self.call("run", "large.toml", "-o", "whole.h5")
        code = DONE
        while not self.journals():
            code, err = self.interrupt(*self.RUN, number=15)
            self.assertIn(code, (DONE, INTERRUPTED), err)
            if code == DONE:
                (self.folder / "out.h5").unlink()
        journal, = self.journals()
        return journal, self.hash_of("whole.h5")

    # --- files ---

    def crafted(self, edit):
        """A result that is edited without its seal, with the content hash that then is right wherever that can be made."""
        path = self.folder / "crafted.h5"
        data = (self.folder / "small.h5").read_bytes()
        path.write_bytes(data[:-integrity.SEAL_SIZE])
        with h5py.File(path, "r+") as file:
            edit(file)
        try:
            with h5py.File(path, "r+") as file:
                file.attrs["content_hash"] = integrity.content_hash(file)
        except Exception:
            pass
        return path

    def test_files_that_lead_elsewhere_are_not_read(self):
        self.small()
        secret = self.folder / "secret.bin"
        secret.write_bytes(np.arange(64, dtype=float).tobytes())
        with h5py.File(self.folder / "other.h5", "w") as file:
            file["position"] = np.arange(3.0)

        def of_itself(file):
            name = next(n for n in file["tables/position"] if file["tables/position"][n].dtype == np.float64)
            layout = h5py.VirtualLayout(shape=file[f"tables/position/{name}"].shape, dtype=float)
            layout[...] = h5py.VirtualSource(".", f"/tables/position/{name}", shape=layout.shape)
            del file[f"tables/position/{name}"]
            file.create_virtual_dataset(f"tables/position/{name}", layout)

        def external(file):
            table = file["tables/position"]
            name = next(n for n in table if table[n].dtype == np.float64)
            shape = table[name].shape
            del table[name]
            table.create_dataset(name, shape, float, external=[(str(secret), 0, 8 * shape[0])])

        def link(file):
            file["tables/position/linked"] = h5py.ExternalLink(str(self.folder / "other.h5"), "/position")

        def root_link(file):
            del file["samples"]
            file["samples"] = h5py.SoftLink("/tables")

        def no_columns(file):
            for name in list(file["inputs"]):
                for column in list(file["inputs"][name]):
                    del file["inputs"][name][column]

        for edit, says in ((of_itself, "elsewhere|damaged"), (external, "elsewhere"), (link, "leads elsewhere"),
                           (root_link, "leads elsewhere"), (no_columns, "not as surveymc stores files")):
            with self.subTest(edit.__name__):
                path = self.crafted(edit)
                for command in (("show", path), ("show", path, "--json"), ("rerun", path))[2 if edit is no_columns else 0:]:
                    self.call(*command, code=CANNOT_WRITE, says=says)
                self.call("run", "small.toml", "-o", path)  # whatever it is, it is kept
                self.assertEqual([p.name for p in self.folder.glob("crafted.*.h5")], ["crafted.1.h5"])
                (self.folder / "crafted.1.h5").unlink()

    def test_what_crashes_ends_in_the_child(self):
        """Any bytes behind a whole beginning: HDF5 may crash at them, the program may not."""
        data = self.small().read_bytes()[:-integrity.SEAL_SIZE]
        path = self.folder / "damaged.h5"
        for at in range(96, len(data), len(data) // 20):
            bad = bytearray(data)
            bad[at:at + 8] = b"\xff" * 8
            path.write_bytes(bytes(bad))
            done = subprocess.run([*self.PROGRAM, "show", path, "--list"], capture_output=True, text=True, timeout=PATIENCE)
            self.assertIn(done.returncode, (DONE, CANNOT_WRITE), f"{at}: {done.stderr}")

    def test_stack_and_tables_of_functions_are_guarded(self):
        read = lambda option: subprocess.run(["readelf", option, "--wide", self.PROGRAM[0]], text=True, capture_output=True, check=True).stdout
        symbols = read("--dyn-syms")
        if "__asan_init" in symbols or "__tsan_init" in symbols:
            self.skipTest("sanitizers have checks of their own")
        self.assertIn("__stack_chk_fail", symbols)
        self.assertIn("GNU_RELRO", read("--segments"))
        self.assertRegex(read("--dynamic"), r"BIND_NOW|FLAGS_1.*NOW")

    def test_no_library_of_the_working_folder_is_loaded(self):
        loaded = subprocess.run(["ldd", *self.PROGRAM], capture_output=True, text=True, check=True).stdout
        names = re.findall(r"^\t(lib[^/ ]+) =>", loaded, re.MULTILINE)
        self.assertGreater(len(names), 5, loaded)
        for name in names:
            (self.folder / name).write_text("anything\n")
        self.call("check", "small.toml", program=[str(Path(self.PROGRAM[0]).resolve())])

    def test_names_with_escape_sequences(self):
        evil = "\x1b]0;owned\x07\x1b[31m\x9b2J"
        self.small()
        path = self.crafted(lambda file: (file.attrs.__setitem__("title", evil), file.attrs.__setitem__("git_revision", evil),
                                          file["tables/position"].attrs.__setitem__("long_name", evil)))
        for command in (("show", path), ("show", path, "position"), ("show", path, "--json")):
            self.assertNotRegex(self.call(*command), ESCAPE)
        for command in (("run", f"a{evil}.toml"), ("show", f"a{evil}.h5"), ("merge", f"a{evil}.part", "-o", "m.h5"), (evil,),
                        ("run", "small.toml", "--set", f"{evil}=1"), ("status", evil)):
            done = subprocess.run([*self.PROGRAM, *command], cwd=self.folder, capture_output=True, text=True, timeout=PATIENCE)
            self.assertIn(done.returncode, (64, BAD_INPUT, CANNOT_WRITE), done.stderr)
            self.assertNotRegex(done.stdout + done.stderr, ESCAPE)
        odd = self.folder / f"odd{evil}.h5"
        shutil.copy(self.folder / "small.h5", odd)
        self.assertNotRegex(self.call("run", "small.toml", "-o", odd, "--seed", 3), ESCAPE)

    def test_marks_of_direction_and_bytes_that_are_no_text(self):
        """A name may not look like another one, and a byte of no UTF-8 may be an escape sequence, too."""
        marks = "\u202e\u2066\u200f\u061c\u2028\x9b"
        self.small()
        marked = re.compile(f"[{marks}]")
        named = self.folder / "small.toml"
        named.write_text(f'title = "a{marks}b"\n' + re.sub("(?m)^title.*\n", "", named.read_text()), encoding="utf-8")
        self.call("run", "small.toml", "-o", f"o{marks}.h5")
        self.call("run", "small.toml", "-o", f"other{marks}.h5", "--seed", 3)
        self.call("run", "small.toml", "--shard", "0/2", "-o", f"p{marks}/")
        name, parts = f"o{marks}.h5", f"p{marks}"
        for command in (("check", named), ("show", name), ("show", name, "--json"), ("rerun", name), ("status", parts),
                        ("run", named, "-o", name, "--overwrite"), ("diff", name, f"other{marks}.h5"), ("new", "msa_position", "-o", f"n{marks}.toml")):
            done = subprocess.run([*self.PROGRAM, *command], cwd=self.folder, capture_output=True, timeout=PATIENCE)
            said = (done.stdout + done.stderr).decode()
            self.assertNotRegex(said, marked, command)
            self.assertNotRegex(said, ESCAPE, command)
        text = self.call("check", named)
        (self.folder / "resolved.toml").write_text(text[:text.index("\n# ")])  # \\u202e is the same title
        self.assertEqual(re.search("config hash ([0-9a-f]+)", self.call("check", "resolved.toml"))[1],
                         re.search("config hash ([0-9a-f]+)", text)[1])
        done = subprocess.run([*self.PROGRAM, "show", b"no\x9b2J.h5"], cwd=self.folder, capture_output=True, timeout=PATIENCE)
        self.assertNotIn(b"\x9b", done.stderr)

    def test_a_cell_of_csv_is_no_formula(self):
        self.small()
        texts = ["=1+1", "+cmd|' /C calc'!A0", "-2+3", "@SUM(A1)", "-1.5", "+2e3", "gain_x"]

        def edit(file):
            column = file["tables/parameters/quantity"]
            for i, text in enumerate(texts[:len(column)]):
                column[i] = text
        path = self.crafted(edit)
        cells = [row["quantity"] for row in csv.DictReader(self.call("show", path, "parameters", "--csv").splitlines())]
        expected = ["'" + t for t in texts[:4]] + texts[4:]
        self.assertEqual(cells[:len(texts)], expected[:len(cells)])
        self.assertGreater(len(cells), 5)

    def test_names_of_commands_are_quoted_for_a_shell(self):
        name = "my well; touch 'x'.toml"
        said = self.call("new", "msa_position", "-o", name)
        words = shlex.split(said[said.index("then: "):].replace(", surveymc", " surveymc"))
        self.assertEqual(words, ["then:", "surveymc", "check", name, "surveymc", "run", name])
        self.assertIn("surveymc check ./-s.toml,", self.call("new", "msa_position", "-o", "./-s.toml"))
        self.call("run", "small.toml", "-o", "a b.h5")
        self.assertIn("surveymc show 'a b.h5' NAME", self.call("show", "a b.h5", "--list"))

    def test_nesting_is_counted_before_the_parse(self):
        """Parsers call themselves once a level."""
        deep = 30_000
        says = "must be nested at most 256 deep"
        small = (self.folder / "small.toml").read_text().split("[sweep]")[0]
        keys = ".".join("a" * deep)
        for text in (f"{keys} = 1\n", f"[{keys}]\nb = 1\n", f"[[{keys}]]\nb = 1\n", f"x = {'[' * deep}{']' * deep}\n",
                     f"x = {'{a=' * deep}1{'}' * deep}\n", f"x = {{ y = [{{ {keys} = 1 }}] }}\n", f'"a".\'b.c\'.{keys} = "x"\n',
                     "[" + ".".join("a" * 200) + "]\n" + ".".join("b" * 200) + " = 1\n", f"x = \"\"\"'{chr(10)}\"\"\"\n{keys} = 1\n",
                     f'[sweep]\n"{keys}" = [1, 2]\n', f'[[sweep.case]]\nname = "n"\n"{keys}" = 1\n'):
            (self.folder / "deep.toml").write_text(small + text)
            with self.subTest(text[:30]):
                for command in ("check", "run"):
                    self.call(command, "deep.toml", code=BAD_INPUT, says=says)
        for argument in (f"{keys}=1", f"x={'[' * deep}{']' * deep}", f"x={{{keys}=1}}", f"sweep.{keys}=[1]"):
            self.call("check", "small.toml", "--set", argument, code=BAD_INPUT, says=rf"\A.{{,500}}{says}\n\Z")
        self.small()
        forged = self.crafted(lambda file: file.attrs.__setitem__("config", f"{keys} = 1\n" + str(file.attrs["config"])))
        self.call("rerun", forged, code=BAD_INPUT, says=says)
        (self.folder / "model.toml").write_text(f"{keys} = 1\n")
        self.call("models", "any", "--file", "model.toml", code=BAD_INPUT, says=says)
        for text in ('x = "' + "." * 300 + '[[[" # ' + "." * 300 + "[" * 300 + "\n", f"x = [{'1.5, ' * 300}]\n",
                     f"[{'.'.join('a' * 100)}]\n{'.'.join('b' * 156)} = 1\n", "x = " + 3 * "'" + "\n" + "[a.b.c]\n" * 300 + 3 * "'" + "\n"):
            (self.folder / "flat.toml").write_text(small + text)
            self.assertNotIn(says, self.call("check", "flat.toml", code=BAD_INPUT, says="unknown key"))

    def test_a_sweep_that_never_ends_is_refused_with_the_size_of_its_result(self):
        million = "{ from = 1.0, to = 1000000.0, step = 1.0 }"
        with open(self.folder / "small.toml", "r+") as file:
            small = file.read().split("[sweep]")[0]
            file.seek(0)
            file.write(f'{small}[sweep]\n"noise.scale" = {million}\n"noise.magnetometer_nT" = {million}\n')
        self.call("run", "small.toml", "-o", "out.h5", code=BAD_INPUT,
                  says=r"small\.toml: sweep: 1000000000000 points in one run: the result would have at least 64 TB")
        self.assertIn("1000000000000", self.call("plan", "small.toml", "--count"))

    def test_values_that_are_accepted_run(self):
        """An overflow in the statistics is no internal error: it is refused before the run, or an infinite interval."""
        smoke = Path(__file__).resolve().parents[2] / "configs" / "smoke"
        for config, value, codes in (
                ("gross_error_detection", "sigma.magnetometer_noise_nT=1e-7", {BAD_INPUT}),
                ("calibration", "noise.magnetometer_nT=1e-6", {DONE}), ("chained", "model.magnetometer_xy.random_nT=1e100", {BAD_INPUT}),
                ("chained", "model.field.walk_nT=1e100", {BAD_INPUT}), ("chained", "model.field.walk_nT=1e30", {DONE})):
            with self.subTest(config=config, value=value):
                done = subprocess.run([*self.PROGRAM, "run", smoke / f"{config}.toml", "--set", value, "-q", "--overwrite",
                                       "-o", self.folder / "any.h5"], capture_output=True, text=True, timeout=PATIENCE)
                self.assertIn(done.returncode, codes, done.stderr)
                if done.returncode == BAD_INPUT:
                    self.assertRegex(done.stderr, f"error: --set {value}: {value.split('=')[0]} = .*: must be ")

    def test_an_old_result_that_cannot_be_read_is_called_so(self):
        path = self.small()
        data = bytearray(path.read_bytes())
        data[len(data) // 2] ^= 1
        path.write_bytes(data)
        self.call("run", "small.toml", "-o", "small.h5", code=CANNOT_WRITE,
                  says=r"exists and cannot be read \(is damaged or was edited: its checksum does not match\): refusing")
        self.assertEqual(path.read_bytes(), data)

    # --- descriptors, memory, machines ---

    def test_closed_descriptors(self):
        whole = self.small()
        for closed in ((2,), (0, 1, 2), (0, 2)):
            with self.subTest(closed):
                def close():
                    for number in closed:
                        os.close(number)
                go = lambda *more: subprocess.run([*self.PROGRAM, "run", "small.toml", "-o", "out.h5", "--threads", "1", *more],
                                                  cwd=self.folder, preexec_fn=close, timeout=PATIENCE).returncode
                codes = [go("--checkpoint-seconds", "0.001", "--max-seconds", "0.004")]
                for journal in self.journals():
                    self.assertTrue(journal.read_bytes().startswith(b"SMCJRNL1"))
                    records(journal.read_bytes())
                codes.append(go("--resume"))
                # With standard output closed, not all was printed: that is an error, but the result is there.
                self.assertIn(codes[-1], (CANNOT_WRITE,) if 1 in closed else (DONE,))
                self.assertEqual(self.hash_of("out.h5"), self.hash_of("small.h5"))
                (self.folder / "out.h5").unlink()

    def test_little_memory(self):
        """Under every limit of memory the program ends by itself, with a message and the code for it."""
        self.small()
        peak = 0
        run, readers = ("run", "small.toml", "-o", "out.h5", "--threads", "2", "--overwrite"), (("rerun", "small.h5"), ("show", "small.h5"))
        # HDF5 would end or crash at some of the least that are enough to start
        least = [(tenths / 10, readers) for tenths in range(400, 520, 4)]
        for mebibytes, commands in (*least, *((m, (run, *readers)) for m in (*range(40, 112, 6), *range(112, 200, 12), 260, 400))):
            for command in commands:
                done = subprocess.run([*self.PROGRAM, *command], cwd=self.folder, capture_output=True, text=True, timeout=PATIENCE,
                                      preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (int(mebibytes * 2**20),) * 2))
                told = f"{mebibytes} MiB, {command}: {done.returncode}: {done.stderr}"
                if done.returncode == 127:  # the loader: the program has not begun
                    continue
                peak = max(peak, mebibytes)
                self.assertIn(done.returncode, (DONE, INTERNAL, NO_MACHINE, CANNOT_WRITE, ABORTED), told)
                if done.returncode != DONE:
                    self.assertRegex(done.stderr, "memory|OMP thread", told)
                    self.assertNotRegex(done.stderr, "internal error|terminate", told)
                self.assertEqual(self.temporaries(), [], told)
        self.assertGreater(peak, 0)

    def test_small_stacks(self):
        """A limit that may be raised is raised; else the program ends with a message before it begins."""
        whole = self.hash_of(self.small().name)
        run = (*self.PROGRAM, "run", "small.toml", "-o", "out.h5", "--threads", "3", "--overwrite")
        for limits, code in (
                ((32, 8192), DONE), ((64, 1024), DONE), ((64, 64), NO_MACHINE), ((64, 1023), NO_MACHINE)):
            limit = lambda: resource.setrlimit(resource.RLIMIT_STACK, tuple(kibibytes << 10 for kibibytes in limits))
            done = subprocess.run(run, cwd=self.folder, capture_output=True, text=True, timeout=PATIENCE, preexec_fn=limit)
            with self.subTest(limits=limits):
                self.assertEqual(done.returncode, code, done.stderr)
                if code == DONE:
                    self.assertEqual(self.hash_of("out.h5"), whole)
                else:
                    self.assertRegex(done.stderr, "ulimit -s.*1024.*raise the limit")

    def test_a_processor_that_lacks_the_instructions(self):
        emulator = shutil.which("qemu-x86_64")
        if not emulator:
            self.skipTest("no qemu-x86_64")
        done = subprocess.run([emulator, "-cpu", "Nehalem", *self.PROGRAM, "list"], capture_output=True, text=True, timeout=PATIENCE)
        self.assertEqual(done.returncode, NO_MACHINE, done.stderr)
        self.assertRegex(done.stderr, "needs a processor with AVX2 and FMA")

    @unittest.skipUnless(os.geteuid() == 0 and shutil.which("unshare"), "needs root, for process numbers of its own")
    def test_two_containers_of_one_host_name(self):
        """Both are process 1 of the same host: neither takes the other's journal or temporary file for its own or a dead one's."""
        alone = ["unshare", "--pid", "--fork", "--kill-child", "--mount-proc", *self.PROGRAM]
        self.assertNotIn("error", subprocess.run([*alone, "check", "small.toml"], cwd=self.folder, capture_output=True, text=True).stderr)
        self.call("run", "large.toml", "-o", "whole.h5")
        for _ in range(2):
            children = [self.start(*self.RUN, "--resume", program=alone) for _ in range(3)]
            ends = [(child.communicate(timeout=PATIENCE)[1], child.returncode) for child in children]
            self.assertEqual([code for _, code in ends], [DONE] * 3, ends)
            self.assertEqual(self.hash_of("out.h5"), self.hash_of("whole.h5"))
            self.assertEqual((self.journals(), self.temporaries()), ([], []))
            (self.folder / "out.h5").unlink()

    def test_settings_change_no_bit(self):
        whole = self.hash_of(self.small().name)
        for number, settings in enumerate((
                {"OMP_NUM_THREADS": "3"}, {"OMP_NUM_THREADS": "1"}, {"OMP_NUM_THREADS": "2,7"}, {"OMP_NUM_THREADS": "many"},
                {"LC_ALL": "de_DE.UTF-8"}, {"LC_ALL": "tr_TR.UTF-8", "LANG": "tr_TR.UTF-8"}, {"LC_NUMERIC": "C.UTF-8"}, {"LC_ALL": "none"},
                {"TZ": "Pacific/Kiritimati"}, {"TZ": "nowhere/at all"}, {"MALLOC_PERTURB_": "165"}, {"LD_PRELOAD": FLOATING_POINT},
                {"SURVEYMC_INSTRUCTION_SET": "x86-64-v3"}, {"GLIBC_TUNABLES": "glibc.cpu.hwcaps=-FMA,-FMA4,-AVX2"})):
            with self.subTest(settings):
                self.call("run", "small.toml", "-o", f"{number}.h5", env=settings)
                self.assertEqual(self.hash_of(f"{number}.h5"), whole)

    def test_variants_of_the_c_library_decide_no_bit(self):
        probe = lambda **more: re.search("probe ([0-9a-f]{8})", self.call("--version", env=more))[1]
        self.assertEqual(probe(), probe(SURVEYMC_INSTRUCTION_SET="x86-64-v3"))
        self.assertEqual(probe(), probe(GLIBC_TUNABLES="glibc.cpu.hwcaps=-FMA,-FMA4"))

    # --- journals and parts of other builds ---

    def test_a_finished_run_is_not_computed_again(self):
        path = self.small()
        before = path.stat()
        said = self.call("run", "small.toml", "-o", "small.h5", "--resume", says="small.h5 is done already")
        self.assertIn("position", said)  # its tables are printed again
        self.assertEqual((path.stat().st_ino, path.stat().st_mtime_ns), (before.st_ino, before.st_mtime_ns))
        self.call("run", "small.toml", "-o", "small.h5", "--resume", "--seed", 2, says="wrote small.h5")  # another config
        self.assertTrue((self.folder / "small.1.h5").exists())

    def test_journals_of_other_builds(self):
        journal, whole = self.interrupted()
        data = journal.read_bytes()
        journal.write_bytes(of_another_program(data, other_numerics))
        self.call(*self.RUN, "--resume", code=CANNOT_WRITE, says="is the journal of another build .*last bits")
        journal.write_bytes(of_another_program(data, another_revision))
        done = subprocess.run([*self.PROGRAM, *self.RUN, "--resume"], cwd=self.folder, capture_output=True, text=True, timeout=PATIENCE)
        self.assertEqual(done.returncode, DONE, done.stderr)
        self.assertRegex(done.stderr, r"is of another build \(surveymc .*SomeCompiler.*\), whose numbers have the same bits: used")
        self.assertRegex(done.stderr, "going on from [1-9]")
        self.assertEqual(self.hash_of("out.h5"), whole)
        self.assertEqual(self.journals(), [])

    def test_parts_of_other_builds(self):
        whole = self.hash_of(self.small().name)
        for shard in (0, 1):
            self.call("run", "small.toml", "--shard", f"{shard}/2", "-o", "p/")
        part, other = sorted((self.folder / "p").glob("*.part"))
        data = part.read_bytes()
        part.write_bytes(part_of_another_program(data, other_numerics))
        self.call("merge", "p", "-o", "m.h5", code=BAD_INPUT, says="was made by another build")
        self.call("run", "small.toml", "--shard", "0/2", "-o", "p/", code=CANNOT_WRITE, says="this part by another build")
        part.write_bytes(part_of_another_program(data, another_revision_as_long))
        self.call("run", "small.toml", "--shard", "0/2", "-o", "p/", says="is done already")
        done = subprocess.run([*self.PROGRAM, "merge", "p", "-o", "m.h5"], cwd=self.folder, capture_output=True, text=True, timeout=PATIENCE)
        self.assertEqual(done.returncode, DONE, done.stderr)
        self.assertRegex(done.stderr, "is of another build .*\\(0+\\).*the same bits: used")
        self.assertEqual(self.hash_of("m.h5"), whole)

    def test_a_journal_with_a_damaged_head(self):
        journal, whole = self.interrupted()
        data = bytearray(journal.read_bytes())
        for first in (8, 16, len(data)):  # its mark, its mark and length, all of it
            (self.folder / "out.h5").unlink(missing_ok=True)
            bad = data[:]
            bad[:first] = b"\x55" * first
            journal.write_bytes(bad)
            self.call(*self.RUN, code=CANNOT_WRITE, says="was not finished")
            done = subprocess.run([*self.PROGRAM, *self.RUN, "--resume"], cwd=self.folder, capture_output=True, text=True, timeout=PATIENCE)
            self.assertEqual(done.returncode, DONE, done.stderr)
            self.assertIn("is damaged; what cannot be read is computed again", done.stderr)
            if len(records(bytes(data))) > 1 and first < len(data):
                self.assertRegex(done.stderr, "going on from [1-9]")  # the records behind it
            self.assertEqual(self.hash_of("out.h5"), whole)
            self.assertEqual(self.journals(), [])
        (self.folder / "out.h5").unlink()
        notes = self.folder / "out.h5.journal.of-mine"
        notes.write_text("a user's notes")
        done = subprocess.run([*self.PROGRAM, *self.RUN], cwd=self.folder, capture_output=True, text=True, timeout=PATIENCE)
        self.assertEqual(done.returncode, DONE, done.stderr)
        self.assertIn("has the name of a journal, but is none", done.stderr)
        self.assertEqual(notes.read_text(), "a user's notes")
        self.assertEqual(self.hash_of("out.h5"), whole)


if __name__ == "__main__":
    program_from_arguments(__doc__)
    FLOATING_POINT = os.path.abspath(sys.argv.pop(1))
    unittest.main()
