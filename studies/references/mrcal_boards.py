#!/usr/bin/python3
"""The real boards of docs/calibration.md calibrated by mrcal from the corners of our tests: RMS, views held out, intrinsics and
the projection's uncertainty over the frame, one table row for each model. Needs Debian's python3-mrcal (2.2).

    build/tests/calib_test --gtest_filter='RealBoards.*' --gtest_output=json:boards.json
    studies/references/mrcal_boards.py boards.json
"""
import json
import sys
import time

import mrcal
import numpy as np

COLUMNS, ROWS, SQUARE_M, WIDTH, HEIGHT = 9, 6, 0.025, 640, 480
FOCAL_START_PX = 530.0
FRAME = np.stack(np.meshgrid(np.linspace(-0.5, WIDTH - 0.5, 25), np.linspace(-0.5, HEIGHT - 0.5, 19)), -1).reshape(-1, 2)
MIDDLE = np.array([0.5 * (WIDTH - 1), 0.5 * (HEIGHT - 1)])


def read_corners(file, name):
    """[view][row][column] x, y, weight."""
    for suite in json.load(open(file))["testsuites"]:
        for test in suite["testsuite"]:
            if name in test:
                pixels = np.array(test[name].split(), float).reshape(-1, ROWS, COLUMNS, 2)
                return np.concatenate([pixels, np.ones(pixels.shape[:-1] + (1,))], -1)
    sys.exit(f"{file}: no test has the property {name}; make it with --gtest_filter='RealBoards.*'")


def inputs_of(observations, model, bent):
    views = len(observations)
    sizes = np.array([[WIDTH, HEIGHT]], np.int32)
    frame_camera = np.stack([np.arange(views), np.zeros(views)], -1).astype(np.int32)
    indices = np.stack([np.arange(views), np.zeros(views), -np.ones(views)], -1).astype(np.int32)
    core, _, frames = mrcal.seed_stereographic(imagersizes=sizes, focal_estimate=FOCAL_START_PX,
                                               indices_frame_camera=frame_camera, observations=observations.copy(),
                                               object_spacing=SQUARE_M)
    return dict(intrinsics=np.hstack([core, np.zeros((1, mrcal.lensmodel_num_params(model) - 4))]),
                extrinsics_rt_fromref=np.zeros((0, 6)), frames_rt_toref=frames, points=None,
                observations_board=observations.copy(), indices_frame_camintrinsics_camextrinsics=indices,
                observations_point=None, indices_point_camintrinsics_camextrinsics=None, lensmodel=model,
                imagersizes=sizes, calobject_warp=np.zeros(2) if bent else None, do_optimize_intrinsics_core=True,
                do_optimize_intrinsics_distortions=False, do_optimize_extrinsics=True, do_optimize_frames=True,
                do_optimize_calobject_warp=False, calibration_object_spacing=SQUARE_M,
                do_apply_outlier_rejection=False, do_apply_regularization=True, verbose=False)


def residuals(inputs):
    x = mrcal.optimizer_callback(**inputs, no_jacobian=True, no_factorization=True)[1]
    return x[:2 * COLUMNS * ROWS * len(inputs["observations_board"])]


def calibrate(observations, model, bent):
    inputs = inputs_of(observations, model, bent)
    mrcal.optimize(**inputs)
    inputs["do_optimize_intrinsics_distortions"] = True
    mrcal.optimize(**inputs)
    if bent:
        inputs["do_optimize_calobject_warp"] = True
        mrcal.optimize(**inputs)
    return inputs


def held_out(observations, model, bent):
    """Each view by turns left out; its pose is then fitted to its corners under the others' lens and bend."""
    found = []
    for v in range(len(observations)):
        others = calibrate(np.delete(observations, v, 0), model, bent)
        one = inputs_of(observations[v:v + 1], model, bent)
        one.update(intrinsics=others["intrinsics"], calobject_warp=others["calobject_warp"],
                   do_optimize_intrinsics_core=False, do_apply_regularization=False)
        mrcal.optimize(**one)
        found.append(residuals(one))
    return np.concatenate(found)


def rms(x):
    return np.sqrt(np.mean(np.sum(x.reshape(-1, 2)**2, -1)))


def deviations(inputs):
    """Of the intrinsics, from the normal equations and the residuals' own scatter."""
    _, x, jacobian, _ = mrcal.optimizer_callback(**inputs, no_factorization=True)
    covariance = np.linalg.inv((jacobian.T @ jacobian).toarray()) * np.mean(residuals(inputs)**2)
    unit = np.sqrt(np.diag(covariance))
    mrcal.unpack_state(unit, **inputs)
    return unit[:4]


def projection(inputs, distance_m):
    """Standard deviation in its worst direction [px]: middle, corner, root mean square over the frame."""
    camera = mrcal.cameramodel(optimization_inputs=inputs, icam_intrinsics=0)
    pixels = np.vstack([MIDDLE, FRAME])
    points = mrcal.unproject(pixels, *camera.intrinsics(), normalize=True)
    if distance_m is not None:
        points *= distance_m / points[:, 2:]
    found = mrcal.projection_uncertainty(points, camera, atinfinity=distance_m is None, what="worstdirection-stdev")
    return f"{found[0]:.3f}, {found[1]:.3f}, {np.sqrt(np.mean(found[1:]**2)):.3f}"


if len(sys.argv) != 2:
    sys.exit(__doc__)
print("| corners | model | RMS [px] | held out [px] | fx ± σ | fy ± σ | cx ± σ | cy ± σ | bend [mm] | σ at 0.4 m | σ at infinity | CPU |")
print("|" + "---|" * 12)
for corners in ("opencv", "ours"):
    observations = read_corners(sys.argv[1], "corners_" + corners)
    for model in ("LENSMODEL_OPENCV4", "LENSMODEL_OPENCV5"):
        for bent in (False, True):
            start = time.process_time()
            inputs = calibrate(observations, model, bent)
            seconds = time.process_time() - start
            sigma = deviations(inputs)
            core = " | ".join(f"{value:.3f} ± {s:.2f}" for value, s in zip(inputs["intrinsics"][0], sigma))
            bend = "{:.2f}, {:.2f}".format(*1e3 * inputs["calobject_warp"]) if bent else "flat"
            print(f"| {corners} | {model[10:]} | {rms(residuals(inputs)):.4f} | {rms(held_out(observations, model, bent)):.4f} "
                  f"| {core} | {bend} | {projection(inputs, 0.4)} | {projection(inputs, None)} | {seconds:.2f} s |")
