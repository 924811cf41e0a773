#!/usr/bin/env python3
"""Writes every scene, or says which of the committed ones their scripts would not write.

    python3 scenes/generate/all.py              writes scenes/*.pbrt
    python3 scenes/generate/all.py FOLDER       writes them to FOLDER
    python3 scenes/generate/all.py --check      writes to a temporary folder and compares: 1 where a byte differs
"""
import contextlib
import importlib
import io
import pathlib
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
SHARED = {"all", "implicit", "pbrt_writer", "shapes"}


def write(folder):
    for script in sorted(HERE.glob("*.py")):
        if script.stem in SHARED:
            continue
        text = io.StringIO()
        with contextlib.redirect_stdout(text):
            importlib.import_module(script.stem).main()
        (folder / (script.stem.replace("_", "-") + ".pbrt")).write_bytes(text.getvalue().encode())


def differences(folder):
    names = {path.name for place in (folder, HERE.parent) for path in place.glob("*.pbrt")}
    for name in sorted(names):
        generated, committed = folder / name, HERE.parent / name
        if not committed.exists():
            yield f"{name}: its script writes it, but it is not in scenes/"
        elif not generated.exists():
            yield f"{name}: no script in scenes/generate writes it"
        elif generated.read_bytes() != committed.read_bytes():
            yield f"{name}: not what its script writes; run scenes/generate/all.py"


def main():
    sys.dont_write_bytecode = True
    if sys.argv[1:] != ["--check"]:
        write(pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else HERE.parent)
        return 0
    with tempfile.TemporaryDirectory() as folder:
        write(pathlib.Path(folder))
        found = list(differences(pathlib.Path(folder)))
    print("\n".join(found) or "every scene is what its script writes")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
