#!/usr/bin/env python3
"""Packs an installed package kappamu as a wheel, by Python's own zipfile: make_wheel.py CONTENT OUT. Prints its path.

The format is that of https://packaging.python.org/specifications/binary-distribution-format/; the numbers come from
pyproject.toml, as for `pip install .`.
"""
import base64
import hashlib
import pathlib
import re
import sys
import sysconfig
import tomllib
import zipfile


def numpy_wanted(header=pathlib.Path("/usr/include/pybind11/detail/common.h")):
    """Before 2.12 pybind11 read the arrays of NumPy 2 by the layout of NumPy 1, as Debian 12's does: pip must not take that."""
    version = [int(re.search(rf"PYBIND11_VERSION_{part} (\d+)", header.read_text())[1]) for part in ("MAJOR", "MINOR")]
    return "numpy" if version >= [2, 12] else "numpy<2"


def main(content, out):
    root = pathlib.Path(__file__).resolve().parent.parent
    project = tomllib.loads((root / "pyproject.toml").read_text())["project"]
    abi = f"cp{sys.version_info.major}{sys.version_info.minor}"
    tag = f"{abi}-{abi}-{sysconfig.get_platform().replace('-', '_').replace('.', '_')}"
    name = f"{project['name']}-{project['version']}"
    metadata = [f"Metadata-Version: 2.1\nName: {project['name']}\nVersion: {project['version']}",
                f"Summary: {project['description']}\nRequires-Python: {project['requires-python']}"]
    metadata += [f"Requires-Dist: {numpy_wanted() if package == 'numpy' else package}" for package in project["dependencies"]]
    for extra, packages in project["optional-dependencies"].items():
        metadata += [f"Provides-Extra: {extra}"] + [f"Requires-Dist: {p}; extra == '{extra}'" for p in packages]
    files = {str(path.relative_to(content)): path.read_bytes() for path in sorted(content.rglob("*"))
             if path.is_file() and "__pycache__" not in path.parts}
    info = f"{name}.dist-info"
    files[f"{info}/METADATA"] = ("\n".join(metadata) + "\n").encode()
    files[f"{info}/WHEEL"] = f"Wheel-Version: 1.0\nGenerator: kappamu\nRoot-Is-Purelib: false\nTag: {tag}\n".encode()
    files[f"{info}/licenses/LICENSE"] = (root / "LICENSE").read_bytes()
    rows = []
    for path, data in files.items():
        digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
        rows.append(f"{path},sha256={digest},{len(data)}")
    rows.append(f"{info}/RECORD,,")
    files[f"{info}/RECORD"] = ("\n".join(rows) + "\n").encode()
    out.mkdir(parents=True, exist_ok=True)
    wheel = out / f"{name}-{tag}.whl"
    with zipfile.ZipFile(wheel, "w", zipfile.ZIP_DEFLATED) as archive:
        for path, data in files.items():
            entry = zipfile.ZipInfo(path)
            entry.external_attr, entry.compress_type = 0o644 << 16, zipfile.ZIP_DEFLATED
            archive.writestr(entry, data)
    print(wheel)


if __name__ == "__main__":
    main(pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2]))
