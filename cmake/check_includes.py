#!/usr/bin/env python3
"""Checks which folder may include which (docs/architecture.md, "Folders"), and who may use which library.

    python3 cmake/check_includes.py [ROOT]

Exit code 0 when the rules hold, 1 with one line per broken rule, 2 for a folder that no rule names (add it here).
"""
import re
import sys
from pathlib import Path

# Folder: what its own files may include besides themselves. Written out in full, so that a new arrow is a decision that shows in a diff.
_CORE = ["core/base", "core/math", "core/film", "core/guiding", "core/learning"]
_SCENE = ["core/image", "core/scene", "core/tracing"]
ALLOWED = {
    "core/base": [],
    "core/math": ["core/base"],
    "core/film": ["core/base", "core/math"],
    "core/guiding": ["core/base", "core/math"],
    "core/image": ["core/base", "core/math"],
    "core/learning": ["core/base", "core/math", "core/film", "core/guiding"],
    "core/scene": ["core/base", "core/math", "core/image"],
    "core/tracing": _CORE + ["core/image", "core/scene"],
    "proto": [],
    "rpc": _CORE + ["proto"],
    "coordinator": _CORE + ["proto", "rpc"],
    "worker": _CORE + _SCENE + ["proto", "rpc"],
    "client": _CORE + _SCENE + ["proto", "rpc"],
}
# Library headers and the only folders that may name them.
LIBRARIES = {
    r"embree3/": ["core/scene"],
    r"OpenImageIO/": ["core/image"],
    r"grpc": ["rpc", "coordinator", "worker", "client"],
    r"google/protobuf": ["rpc", "coordinator", "worker", "client"],
    r"sqlite3": ["coordinator"],
    r"CLI/": ["client", "coordinator", "worker"],
    r"spdlog/": ["core/base"],
    r"xsimd/": ["core/guiding"],
}
FREE = ["tests", "bench"]  # may include anything: they stand outside
INCLUDE = re.compile(r'^\s*#\s*include\s*(["<])([^">]+)[">]')


def folder_of(path):
    parts = path.split("/")
    return "/".join(parts[:2]) if parts[0] == "core" else parts[0]


def check(root):
    broken, unknown = [], set()
    for source in sorted(root.rglob("*")):
        name = source.relative_to(root).as_posix()
        if source.suffix not in (".h", ".cpp", ".cc", ".inl") or name.split("/")[0] in ("build", "out", ".git", *FREE):
            continue
        folder = folder_of(name)
        if folder not in ALLOWED:
            unknown.add(folder)
            continue
        for number, line in enumerate(source.read_text(errors="replace").splitlines(), 1):
            match = INCLUDE.match(line)
            if not match:
                continue
            quoted, target = match.group(1) == '"', match.group(2)
            for library, users in LIBRARIES.items():
                if re.match(library, target) and folder not in users:
                    broken.append(f"{name}:{number}: {folder} must not use <{target}>; only {', '.join(users)} may")
            if not quoted:
                continue
            owner = "proto" if target.endswith(".pb.h") else folder_of(target)
            if "/" not in target and not target.endswith(".pb.h"):
                broken.append(f'{name}:{number}: "{target}" is not written from the repository root')
            elif owner != folder and owner not in ALLOWED[folder]:
                allowed = ", ".join(ALLOWED[folder]) or "nothing"
                broken.append(f"{name}:{number}: {folder} must not include {owner} ({target}); it may include {allowed}")
    return broken, sorted(unknown)


def main():
    root = Path(sys.argv[1] if len(sys.argv) > 1 else Path(__file__).resolve().parent.parent)
    broken, unknown = check(root)
    for line in broken:
        print(line)
    for folder in unknown:
        print(f"{folder}: no include rule names this folder; add one to cmake/check_includes.py")
    if unknown:
        return 2
    if broken:
        return 1
    print("include rules hold")
    return 0


if __name__ == "__main__":
    sys.exit(main())
