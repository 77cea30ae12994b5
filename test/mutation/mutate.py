#!/usr/bin/env python3
"""Mutation testing: changes one operator of the library at a time, and looks whether a test of the library fails.

All mutants are in one program, so that it is compiled once: mutation.h says how. Which mutants a suite of tests reaches is found by a first run;
a mutant is run with the suites that reach it, the fastest first, until one fails. See doc/notes/mutation.md.
"""

import argparse
import concurrent.futures
import functools
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
# The equations, and what selects by them. Multipath interference is tested by the simulator, which is not here.
SOURCES = ["include/fuse_flow/math/[!m]*.h", "include/fuse_flow/math/stereo/*.h", "impl/fuse_flow/impl/fusion/*.hpp", "impl/fuse_flow/impl/filters/*.hpp"]
COPIED = ["CMakeLists.txt", "CHANGELOG.md", "LICENSE", "cmake", "include", "impl", "gpu", "distributed", "apps", "src", "test"]
# Operators between blanks, as clang-format writes those of expressions; without blanks they are references, template arguments or signs.
BINARY = re.compile(r" (\+|-|\*|/|<|<=|>|>=|==|!=|&|\||&&|\|\||\+=|-=|\*=|\|=|&=) ")
EXTREME = re.compile(r"\bstd::(min|max)\((?!\{)")
# Not expressions of values: declarations, preprocessor, what the compiler evaluates, messages.
SKIPPED = re.compile(r"^\s*#|\bconstexpr\b|\bstatic_assert\b|\btemplate\b|\boperator\b|\busing\b|\"|__builtin_prefetch|__restrict")
COMMENT = re.compile(r"//.*?$|/\*.*?\*/", re.DOTALL | re.MULTILINE)


def without_comments(text):
    """The text with blanks in place of its comments, so that places stay."""
    return COMMENT.sub(lambda match: re.sub(r"[^\n]", " ", match.group()), text)


class Mutants:
    """Numbers what it changes."""

    def __init__(self):
        self.all = [None]  # 0 is the program as it is

    def add(self, path, line, source, was, becomes):
        self.all.append({"file": path, "line": line, "source": source.strip(), "was": was, "becomes": becomes})
        return len(self.all) - 1

    def line(self, path, number, text, code):
        """The line, and in it each operator that there is in its code."""
        if SKIPPED.search(code):
            return text
        out, at = [], 0
        found = sorted(list(BINARY.finditer(code)) + list(EXTREME.finditer(code)), key=lambda match: match.start())
        for match in found:
            operator, (begin, end) = match.group(1), match.span(1)
            if begin < at:
                continue
            out.append(text[at:begin])
            add = functools.partial(self.add, path, number, text, operator)
            opposite = {"<": (">=", "<="), "<=": (">", "<"), ">": ("<=", ">="), ">=": ("<", ">")}
            if operator in opposite:
                first = add(opposite[operator][1])
                add(opposite[operator][0])
                out.append(f"{operator} FUSE_FLOW_MUTANT({first}) {operator}")
            elif operator == "&&":
                out.append(f"&& !::fuse_flow_mutation::on<{add('false')}>() &&")
            elif operator == "||":
                out.append(f"|| ::fuse_flow_mutation::on<{add('true')}>() ||")
            elif operator in ("min", "max"):
                number_of_it = add({"min": "max", "max": "min"}[operator])
                out[-1] = out[-1][:-len("std::")]
                out.append(f"::fuse_flow_mutation::{operator}<{number_of_it}>")
            else:
                becomes = {"+": "-", "-": "+", "*": "/", "/": "*", "==": "!=", "!=": "==", "&": "|", "|": "&", "+=": "-=", "-=": "+=",
                           "*=": "/=", "|=": "nothing", "&=": "nothing"}[operator]
                out.append(f"{operator} FUSE_FLOW_MUTANT({add(becomes)}) {operator}")
            at = end
        return "".join(out) + text[at:]

    def file(self, path, relative):
        text = path.read_text()
        lines, code = text.split("\n"), without_comments(text).split("\n")
        path.write_text("\n".join(self.line(relative, k + 1, lines[k], code[k]) for k in range(len(lines))))


def prepare(folder):
    """A copy of the project with all mutants in it."""
    source = folder / "source"
    shutil.rmtree(source, ignore_errors=True)
    source.mkdir(parents=True)
    for part in COPIED:
        (shutil.copytree if (ROOT / part).is_dir() else shutil.copy2)(ROOT / part, source / part)
    mutants = Mutants()
    for pattern in SOURCES:
        for path in sorted(source.glob(pattern)):
            mutants.file(path, str(path.relative_to(source)))
    (folder / "mutants.json").write_text(json.dumps(mutants.all))
    return mutants.all


def build(folder, jobs, options):
    subprocess.run(["cmake", "-S", folder / "source", "-B", folder / "build", "-G", "Ninja", "-DCMAKE_BUILD_TYPE=", "-DFUSE_FLOW_MUTATION=ON",
                    *(f"-DFUSE_FLOW_{part}=OFF" for part in ("BUILD_APPS", "BUILD_TESTS", "BUILD_GPU_TESTS", "BUILD_BENCH", "CUDA", "PYTHON")),
                    *options], check=True, stdout=subprocess.DEVNULL)
    subprocess.run(["cmake", "--build", folder / "build", "--target", "fuse_flow_mutation_tests", "-j", str(jobs)], check=True)
    return folder / "build/bin/fuse_flow_mutation_tests"


def run(program, suites, timeout, **environment):
    """Whether all tests of the suites pass, in their time."""
    try:
        return subprocess.run([program, "--gtest_filter=" + ":".join(suite + ".*" for suite in suites), "--gtest_fail_fast", "--gtest_brief=1"],
                              env={**os.environ, "OMP_NUM_THREADS": "1", **environment}, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                              timeout=timeout, cwd=program.parent).returncode == 0
    except subprocess.TimeoutExpired:
        return False


def suites_of(program, left_out):
    listed = subprocess.run([program, "--gtest_list_tests"], capture_output=True, text=True, check=True).stdout
    names = [line.split()[0].rstrip(".") for line in listed.splitlines() if line and not line.startswith(" ") and line.split()[0].endswith(".")]
    return [name for name in names if not re.search(left_out, name)] if left_out else names


def measure(program, suite, folder):
    """The mutants that a suite meets, and the time that it takes; nothing where it fails as it is."""
    met = folder / (re.sub(r"\W", "_", suite) + ".met")
    begin = time.monotonic()
    if not run(program, [suite], 900, FUSE_FLOW_MUTATION_MET=str(met)):
        return None
    return time.monotonic() - begin, met.read_bytes()


def survives(program, mutant, reaching, times):
    """The suites together that are fast, then each of the others."""
    fast = [suite for suite in reaching if times[suite] < 0.3]
    groups = ([fast] if fast else []) + [[suite] for suite in reaching if times[suite] >= 0.3]
    for group in groups:
        if not run(program, group, 5 + 8 * sum(times[suite] for suite in group), FUSE_FLOW_MUTANT=str(mutant)):
            return False
    return True


def key(mutant):
    return tuple(mutant[name] for name in ("file", "source", "was", "becomes"))


def alive_in(report):
    return {key(mutant) for mutant in json.loads(report.read_text()) if mutant["result"] not in ("killed", "none")}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=pathlib.Path, help="where the copy, the build and report.json go")
    parser.add_argument("-j", "--jobs", type=int, default=os.cpu_count(), help="compilers and tests at a time")
    parser.add_argument("--seconds", type=float, default=float("inf"), help="ends after so many, with the mutants that it has run by then")
    parser.add_argument("--only", default="", help="only mutants of files that match this regular expression")
    parser.add_argument("--again", type=pathlib.Path, metavar="REPORT", help="only the mutants of a report.json that were not killed in it")
    parser.add_argument("--every", type=int, default=1, help="every so many of the mutants alone: a sample")
    parser.add_argument("--leave-out", default="", metavar="REGEX", help="suites that are not run")
    parser.add_argument("--compile-only", action="store_true", help="compiles and ends")
    parser.add_argument("options", nargs="*", help="further options of CMake's, after --")
    args = parser.parse_args()
    begin = time.monotonic()
    args.folder = args.folder.resolve()
    args.folder.mkdir(parents=True, exist_ok=True)
    mutants = prepare(args.folder)
    program = build(args.folder, args.jobs, args.options)
    print(f"{len(mutants) - 1} mutants, compiled in {time.monotonic() - begin:.0f} s", flush=True)
    if args.compile_only:
        return 0

    with concurrent.futures.ThreadPoolExecutor(args.jobs) as pool:
        suites = suites_of(program, args.leave_out)
        measured = dict(zip(suites, pool.map(lambda suite: measure(program, suite, args.folder), suites)))
        for suite in suites:
            if measured[suite] is None:
                print(f"{suite} fails without a mutant, and is left out", flush=True)
        measured = {suite: result for suite, result in measured.items() if result}
        times = {suite: result[0] for suite, result in measured.items()}
        print(f"{len(times)} suites, {sum(times.values()):.0f} s, at {time.monotonic() - begin:.0f} s", flush=True)

        def judge(number):
            if any(met[number] == 2 for _, met in measured.values()):
                return "none"
            reaching = sorted((suite for suite, (_, met) in measured.items() if met[number]), key=times.get)
            if not reaching:
                return "not reached"
            if time.monotonic() - begin > args.seconds:
                return "not run"
            return "survives" if survives(program, number, reaching, times) else "killed"

        numbers = [number for number in range(1, len(mutants)) if re.search(args.only, mutants[number]["file"])][::args.every]
        if args.again:
            alive = alive_in(args.again)
            numbers = [number for number in numbers if key(mutants[number]) in alive]
        with (args.folder / "results.txt").open("w") as out:  # what there is of them if the run is cut off
            for number, result in zip(numbers, pool.map(judge, numbers)):
                mutants[number]["result"] = result
                print(number, result, file=out, flush=True)
    judged = [dict(mutants[number], number=number) for number in numbers]
    (args.folder / "report.json").write_text(json.dumps(judged, indent=1))
    count = {result: sum(mutant["result"] == result for mutant in judged) for result in ("killed", "survives", "not reached", "none", "not run")}
    print(count)
    run_of_them = count["killed"] + count["survives"]
    if run_of_them:
        print(f"{100 * count['killed'] / run_of_them:.1f} % of those that a test reaches are killed, "
              f"{100 * count['killed'] / (run_of_them + count['not reached']):.1f} % of all")
    for mutant in judged:
        if mutant["result"] in ("survives", "not reached"):
            print(f"{mutant['result']}: {mutant['file']}:{mutant['line']}: {mutant['was']} → {mutant['becomes']}: {mutant['source']}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
