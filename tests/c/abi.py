#!/usr/bin/env python3
"""The C ABI against the list of its last release.

    tests/c/abi.py           fails for what was removed or changed since tests/c/abi/catamaran-X.txt
    tests/c/abi.py --write   writes that list; done at a release

X is the ABI version: major.minor while the major version is 0, then the major one. Without a list
of X there was no release of it yet, and everything may change. Additions are always allowed. The
list has the functions with the types of their parameters, the types, the values of the constants,
and the size and fields of each struct, on x86-64 Linux, by the C compiler (CC, default: cc).

A struct that starts with struct_size may grow at its end. A new field must begin where the old
struct ended, not in its padding: an old caller's struct_size would claim that it is set. Only
`reserved` may fill the padding.
"""
import os
import platform
import re
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
HEADER = ROOT / "include/catamaran.h"
# Different in every version.
NOT_ABI = re.compile(r"CATA_VERSION_|CATAMARAN_H$")


def squeeze(text):
    """One blank between words, and none around the rest."""
    text = re.sub(r"\s+", " ", text.strip())
    return re.sub(r" ?([(),*\[\]]) ?", r"\1", text).replace("*", " *").replace("* *", "**")


def without_name(parameter):
    """The type of a parameter: `const double *a` is `const double *`."""
    return re.sub(r"\b(\w+)(\[\d*\])?$", r"\2", parameter).strip() if " " in parameter else parameter


def declarations(text):
    """What the header declares: {key: type} and {struct: {field: type}}."""
    text = re.sub(r"/\*.*?\*/|//[^\n]*", " ", text, flags=re.S)
    # `struct cata_x` and `cata_x` are one type.
    text = re.sub(r"(?<!typedef )\bstruct (cata_\w+)", r"\1", text)
    constants = re.findall(r"^#define +(CATA_\w+) +\S", text, flags=re.M)
    text = re.sub(r'^#.*|extern "C" \{|^\}\s*$', "", text, flags=re.M)
    entries, structs = {}, {}
    for name in constants:
        entries[f"constant {name}"] = None

    def struct(match):
        tag, body, name = match.groups()
        if "(" in body or tag != name:
            sys.exit(f"{HEADER.name}: struct {name} is not a plain one: teach {Path(__file__).name}")
        structs[name] = {}
        for field in filter(None, map(squeeze, body.split(";"))):
            kind, field_name, array = re.fullmatch(r"(.*?)(\w+)((?:\[\w+\])*)", field).groups()
            structs[name][field_name] = kind.strip() + array
        return ""

    text = re.sub(r"typedef struct (\w+) \{(.*?)\} (\w+);", struct, text, flags=re.S)
    for statement in filter(None, map(squeeze, text.split(";"))):
        function = re.fullmatch(r"(?!typedef)(.*?)\b(cata_\w+)\((.*)\)", statement)
        if opaque := re.fullmatch(r"typedef struct (\w+) \1", statement):
            entries[f"opaque {opaque[1]}"] = "struct"
        elif callback := re.fullmatch(r"typedef (.*)\( \*(\w+)\)\((.*)\)", statement):
            types = ", ".join(map(without_name, callback[3].split(",")))
            entries[f"callback {callback[2]}"] = f"{callback[1].strip()} (*)({types})"
        elif alias := re.fullmatch(r"typedef (\w+) (\w+)", statement):
            entries[f"type {alias[2]}"] = alias[1]
        elif function:
            types = ", ".join(map(without_name, function[3].split(",")))
            entries[f"function {function[2]}"] = f"{function[1].strip()} ({types})"
        else:
            sys.exit(f"{HEADER.name}: not understood: {statement}")
    return entries, structs


def measured(entries, structs):
    """The values of constants, and the sizes and offsets of structs, by a C program."""
    lines = []
    for key in entries:
        kind, name = key.split(" ", 1)
        if kind == "constant" and not NOT_ABI.match(name):
            # An integer or a floating-point number, and none that a double can't hold.
            lines.append(f'printf("{key} = %.17g\\n", (double)({name}));')
    for name, fields in structs.items():
        lines.append(f'printf("struct {name} = %zu bytes\\n", sizeof({name}));')
        for field, kind in fields.items():
            lines.append(
                f'printf("field {name}.{field} = {kind} at %zu, %zu bytes\\n",'
                f" offsetof({name}, {field}), sizeof((({name} *)0)->{field}));"
            )
    with tempfile.TemporaryDirectory() as folder:
        source, program = Path(folder, "abi.c"), Path(folder, "abi")
        body = "\n    ".join(lines)
        source.write_text(
            f"#include <catamaran.h>\n#include <stdio.h>\nint main(void)\n{{\n    {body}\n    return 0;\n}}\n"
        )
        compiler = os.environ.get("CC", "cc").split()
        subprocess.run([*compiler, f"-I{HEADER.parent}", "-o", program, source], check=True)
        output = subprocess.run([program], check=True, capture_output=True, text=True).stdout
    return dict(line.split(" = ", 1) for line in output.splitlines())


def present():
    """{key: value} of the header as it is, and the ABI version."""
    text = HEADER.read_text()
    entries, structs = declarations(text)
    found = {k: v for k, v in entries.items() if v is not None and not NOT_ABI.match(k.split()[1])}
    found.update(measured(entries, structs))
    major, minor = (
        int(re.search(rf"#define CATA_VERSION_{part} (\d+)", text)[1]) for part in ("MAJOR", "MINOR")
    )
    return found, f"0.{minor}" if major == 0 else str(major)


def broken(old, new):
    """What a program that was compiled with the old header would trip over."""
    for key, value in old.items():
        if key not in new:
            yield f"removed: {key} = {value}"
        elif new[key] != value and not (key.startswith("struct ") and may_grow(key, old, new)):
            yield f"changed: {key} = {new[key]}, was {value}"
    for key, value in new.items():
        struct = f"struct {key.split()[1].split('.')[0]}"
        filler = ".reserved" in key
        if key.startswith("field ") and key not in old and struct in old and not filler:
            at = int(re.search(r" at (\d+), ", value)[1])
            if at < int(old[struct].split()[0]):
                yield f"added inside the old struct: {key} = {value}; it had {old[struct]}"


def may_grow(key, old, new):
    """Whether a struct tells its size to the library, and became larger."""
    versioned = f"field {key.split()[1]}.struct_size" in old
    return versioned and int(new[key].split()[0]) > int(old[key].split()[0])


def main():
    if sys.argv[1:] not in ([], ["--write"]):
        sys.exit(__doc__)
    if platform.machine() != "x86_64":
        print("abi: the list is for x86-64, left out")
        return
    new, version = present()
    path = ROOT / f"tests/c/abi/catamaran-{version}.txt"
    if sys.argv[1:]:
        head = f"# The C ABI {version} of the last release. Written by tests/c/abi.py --write.\n"
        path.write_text(head + "".join(f"{k} = {new[k]}\n" for k in sorted(new)))
        print(f"abi: {len(new)} entries in {path.relative_to(ROOT)}")
        return
    if not path.exists():
        print(f"abi: no release of {version} yet, everything may change")
        return
    lines = [line for line in path.read_text().splitlines() if not line.startswith("#")]
    old = dict(line.split(" = ", 1) for line in lines)
    faults = list(broken(old, new))
    if faults:
        print("\n".join(faults), file=sys.stderr)
        sys.exit(f"abi: {len(faults)} entries of {path.relative_to(ROOT)} broken; see tests/c/abi.py")
    added = sum(key not in old for key in new)
    print(f"abi: {len(old)} entries of {path.name} kept, {added} added")


main()
