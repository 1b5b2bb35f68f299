#!/usr/bin/env python3
"""bempp-cl on the meshes and lights of `kappamu-studies boundary --fields`: the table of docs/boundary-integral.md. Needs,
in the Python that runs this, bempp-cl (pip install bempp-cl numba meshio). It stores dense matrices: meshes of more than
10,000 triangles are left out.

    kappamu-studies boundary --fields -o out/
    studies/references/bempp_boundary.py out/
"""
import json
import pathlib
import sys
import time

import bempp_cl.api as bempp
import numpy as np
import scipy.sparse.linalg

MOST_TRIANGLES = 10_000
DIRECTION = np.array([1.0, 2.0, 3.0]) / np.sqrt(14.0)  # as in studies/boundary/boundary_bench.cpp


def solved(vertices, triangles, q, decay, robin):
    """Fluence per triangle, Galerkin with constants: (I/2 + K + rV) u = rV q; iterations and CPU seconds."""
    start = time.process_time()
    grid = bempp.Grid(vertices.T, triangles.T.astype(np.uint32))
    space = bempp.function_space(grid, "DP", 0)
    layers = bempp.operators.boundary.modified_helmholtz
    single = layers.single_layer(space, space, space, decay, assembler="dense").weak_form()
    double = layers.double_layer(space, space, space, decay, assembler="dense").weak_form()
    mass = bempp.operators.boundary.sparse.identity(space, space, space).weak_form()
    areas = np.asarray(mass @ np.ones(len(q)))
    system = scipy.sparse.linalg.LinearOperator(
        (len(q), len(q)), lambda u: (0.5 * (mass @ u) + double @ u + robin * (single @ u)) / areas)
    iterations = []
    u, failed = scipy.sparse.linalg.gmres(system, robin * (single @ q) / areas, rtol=1e-8, restart=100,
                                          callback=iterations.append, callback_type="pr_norm")
    assert failed == 0
    return u, len(iterations), time.process_time() - start


def norm(areas, values):
    return np.sqrt(np.sum(areas * values**2))


def main(folder):
    record = json.loads((folder / "boundary.json").read_text())
    decay = np.sqrt(record["mu_per_mm"] / record["kappa_mm"])
    robin = 1.0 / (2.0 * record["A"] * record["kappa_mm"])
    print("| mesh | error, ours | error, bempp-cl | apart | CPU s, ours | CPU s, bempp-cl | iterations, ours, bempp-cl |")
    print("|---|---|---|---|---|---|---|")
    for row in record["rows"]:
        if row["triangles"] > MOST_TRIANGLES:
            continue
        name = f"{row['shape']}-{row['triangles']}"
        vertices, triangles, q, ours = (np.load(folder / name / f"{what}.npy")
                                        for what in ("vertices", "triangles", "q", "fluence"))
        corners = vertices[triangles.astype(int)]
        areas = 0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
        exact = np.exp(decay * corners.mean(axis=1) @ DIRECTION)
        theirs, iterations, seconds = solved(vertices, triangles, q, decay, robin)
        size = norm(areas, exact)
        print(f"| {name} | {norm(areas, ours - exact) / size:.2e} | {norm(areas, theirs - exact) / size:.2e} "
              f"| {norm(areas, ours - theirs) / size:.2e} | {row['cpu_s']:.2f} | {seconds:.2f} "
              f"| {row['iterations']}, {iterations} |", flush=True)


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    main(pathlib.Path(sys.argv[1]))
