"""Plants and beams in motion by other libraries.

    rods.py FOLDER RIVAL ITERATIONS

It reads parents, heads, tails, radii, moduli, shears, masses, step, frames and damping of FOLDER,
.npy each, in SI units with z upwards; writes theirs.npy, the tails after so many steps of that
length from rest, and prints: median seconds of a step, bytes, seconds of the preparation, the
largest gap between segments in metres.

Rivals: pypbd (the direct solver for stiff rods of Deul, Kugelstadt, Weiler and Bender 2018 by their
authors; ITERATIONS of Newton's method a step; it has no damping, so velocities are multiplied
between steps, which is not timed) and elastica (PyElastica: a Cosserat rod with stretch and shear,
whose explicit steps are STABLE of the shortest wave; only a uniform rod without branches; the
compilation by numba is not timed).
"""

import contextlib
import io
import resource
import statistics
import sys
import time

import numpy as np

# A joint of pypbd has a modulus, a radius and a length; only its stiffness, from all, matters.
RADIUS = 1e-3
INERTIA = np.pi / 4 * RADIUS**4

# Explicit steps as a part of the time in which a wave of stretch crosses a segment, or one of shear
# the radius; twice as long ones are unstable.
STABLE = 0.5


def joint_stiffness(parents, lengths, radii, moduli, shears):
    """Bending and twisting stiffness of joints to parents: compliances of halves are added."""
    moment = np.pi / 4 * radii**4
    bend, twist = lengths / (2 * moduli * moment), lengths / (4 * shears * moment)
    above = np.where(parents >= 0, parents, 0)
    return tuple(1 / (c + np.where(parents >= 0, c[above], 0.0)) for c in (bend, twist))


def frame(direction):
    """The rotation, as a matrix, whose second axis is the direction."""
    other = np.eye(3)[np.argmin(np.abs(direction))]
    first = np.cross(direction, other)
    first /= np.linalg.norm(first)
    return np.stack([first, direction, np.cross(first, direction)], axis=1)


def pypbd_steps(plant, iterations):
    import pypbd

    parents, heads, tails, radii = (plant[name] for name in ("parents", "heads", "tails", "radii"))
    # Its gravity points along -y.
    turned = np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])
    heads, tails = heads @ turned.T, tails @ turned.T
    lengths = np.linalg.norm(tails - heads, axis=1)
    bend, twist = joint_stiffness(parents, lengths, radii, plant["moduli"], plant["shears"])
    start = time.perf_counter()
    simulation = pypbd.Simulation.getCurrent()
    simulation.initDefault()
    model = simulation.getModel()
    stepper = simulation.getTimeStep()
    stepper.setValueUInt(pypbd.TimeStepController.NUM_SUB_STEPS, 1)
    stepper.setValueUInt(pypbd.TimeStepController.MAX_ITERATIONS, iterations)
    stepper.setValueUInt(pypbd.TimeStepController.MAX_ITERATIONS_V, 0)
    pypbd.TimeManager.getCurrent().setTimeStepSize(plant["step"][0])
    points, triangles = pypbd.VertexData(), pypbd.IndexedFaceMesh()
    corners = np.array([[-1.0, -1, -1], [1, 0, 0], [0, 1, 0], [0, 0, 1]]) * 1e-4
    for corner in corners:
        points.addVertex(corner)
    faces = [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]]
    triangles.initMesh(len(corners), 6, len(faces))
    for face in faces:
        triangles.addFace(face)
    triangles.buildNeighbors()

    def body(middle, rotation, mass, inertia):
        one = model.addRigidBody(1.0, points, triangles, middle, rotation, np.ones(3), False)
        # The mesh gave it a mass, and turned it to its own principal axes.
        one.setMass(mass)
        one.setInertiaTensor(inertia)
        # The centre of the mesh is that of the body.
        for place in (one.setPosition, one.setPosition0, one.setOldPosition, one.setLastPosition):
            place(middle)
        one.setRotationMatrix(rotation)
        q = quaternion(rotation)
        for turn in (one.setRotation, one.setRotation0, one.setOldRotation, one.setLastRotation):
            turn(q)
        one.rotationUpdated()
        return one

    root = int(np.flatnonzero(parents < 0)[0])
    upwards = np.array([0.0, 1.0, 0.0])
    body(heads[root] - 0.5e-3 * upwards, frame((tails - heads)[root] / lengths[root]), 0.0, np.ones(3))
    segments = []
    for v in range(len(parents)):
        direction = (tails[v] - heads[v]) / lengths[v]
        mass, l, r = plant["masses"][v], lengths[v], radii[v]
        across, along = mass * (l * l / 12 + r * r / 4), mass * r * r / 2
        middle = 0.5 * (heads[v] + tails[v])
        segments.append(body(middle, frame(direction), mass, np.array([across, along, across])))
    above = np.where(parents >= 0, parents, root)
    mean = np.where(parents >= 0, 0.5 * (lengths + lengths[above]), lengths)
    pairs = [(int(p) + 1 if p >= 0 else 0, v + 1) for v, p in enumerate(parents)]
    model.addDirectPositionBasedSolverForStiffRodsConstraint(
        pairs, list(heads), [RADIUS] * len(pairs), list(mean), list(bend * mean / INERTIA), list(twist * mean / (2 * INERTIA))
    )
    prepared = time.perf_counter() - start
    kept = np.exp(-plant["damping"][0] * plant["step"][0])
    seconds = []
    for _ in range(int(plant["frames"][0])):
        start = time.perf_counter()
        stepper.step(model)
        seconds.append(time.perf_counter() - start)
        for one in segments:
            one.setVelocity(kept * one.getVelocity())
            one.setAngularVelocity(kept * one.getAngularVelocity())
    middles = np.array([segment.getPosition().ravel() for segment in segments])
    arms = np.array([segment.getRotationMatrix()[:, 1] for segment in segments]) * (lengths / 2)[:, None]
    ends = np.where((parents >= 0)[:, None], (middles + arms)[above], heads)
    gap = np.linalg.norm(middles - arms - ends, axis=1).max()
    return (middles + arms) @ turned, statistics.median(seconds), prepared, gap


def quaternion(matrix):
    """The quaternion (x, y, z, w) of a rotation."""
    k = np.array([matrix[0, 0], matrix[1, 1], matrix[2, 2]])
    w2 = 1 + k.sum()
    squares = np.append(1 + 2 * k - k.sum(), w2) / 4
    i = int(np.argmax(squares))
    q = np.empty(4)
    q[i] = np.sqrt(squares[i])
    a, b, c = (matrix[2, 1] - matrix[1, 2], matrix[0, 2] - matrix[2, 0], matrix[1, 0] - matrix[0, 1])
    if i == 3:
        q[:3] = np.array([a, b, c]) / (4 * q[3])
    else:
        j, k = (i + 1) % 3, (i + 2) % 3
        q[j] = (matrix[j, i] + matrix[i, j]) / (4 * q[i])
        q[k] = (matrix[k, i] + matrix[i, k]) / (4 * q[i])
        q[3] = (a, b, c)[i] / (4 * q[i])
    return q


def elastica_steps(plant):
    import elastica

    heads, tails, radii, masses = (plant[name] for name in ("heads", "tails", "radii", "masses"))
    n, radius, modulus, shear = len(heads), radii[0], plant["moduli"][0], plant["shears"][0]
    if any(np.ptp(plant[name]) > 0 for name in ("radii", "masses", "moduli")) or (plant["parents"] != np.arange(n) - 1).any():
        sys.exit("elastica: only a uniform rod without branches")
    along = (tails[-1] - heads[0]) / np.linalg.norm(tails[-1] - heads[0])
    density = masses.sum() / (np.pi * radius**2 * np.linalg.norm(tails[-1] - heads[0]))
    # It holds the first of n segments, about whose middle the rod bends first: that is our base.
    length = np.linalg.norm(tails[-1] - heads[0]) * n / (n - 0.5)

    class System(elastica.BaseSystemCollection, elastica.Constraints, elastica.Forcing, elastica.Damping):
        pass

    frame_seconds, frames = plant["step"][0], int(plant["frames"][0])
    longest = STABLE * min(length / n * np.sqrt(density / modulus), radius * np.sqrt(density / shear))
    steps = int(np.ceil(frame_seconds / longest))
    step = frame_seconds / steps

    def system():
        start = time.perf_counter()
        whole = System()
        rod = elastica.CosseratRod.straight_rod(
            n, tails[-1] - length * along, along, np.cross(along, [0.0, 1.0, 0.0]), length, radius, density,
            youngs_modulus=modulus, shear_modulus=shear,
        )
        whole.append(rod)
        whole.constrain(rod).using(
            elastica.OneEndFixedBC, constrained_position_idx=(0,), constrained_director_idx=(0,)
        )
        whole.add_forcing_to(rod).using(elastica.GravityForces, acc_gravity=np.array([0.0, 0.0, -9.81]))
        whole.dampen(rod).using(
            elastica.AnalyticalLinearDamper, uniform_damping_constant=plant["damping"][0], time_step=step
        )
        whole.finalize()
        return whole, rod, time.perf_counter() - start

    stepper = elastica.PositionVerlet()
    with contextlib.redirect_stdout(io.StringIO()):
        elastica.integrate(stepper, system()[0], 10 * step, 10, progress_bar=False)
        whole, rod, prepared = system()
        seconds = []
        for _ in range(frames):
            start = time.perf_counter()
            elastica.integrate(stepper, whole, frame_seconds, steps, progress_bar=False)
            seconds.append(time.perf_counter() - start)
    return rod.position_collection[:, 1:].T.copy(), statistics.median(seconds), prepared, 0.0


def main():
    folder, rival = sys.argv[1:3]
    names = ("parents", "heads", "tails", "radii", "moduli", "shears", "masses", "step", "frames", "damping")
    plant = {name: np.load(f"{folder}/{name}.npy") for name in names}
    for name in names:
        if plant[name].shape[1:] == (1,):
            plant[name] = plant[name].ravel()
    plant["parents"] = plant["parents"].astype(int)
    if rival == "pypbd":
        tails, seconds, prepared, gap = pypbd_steps(plant, int(sys.argv[3]))
    elif rival == "elastica":
        tails, seconds, prepared, gap = elastica_steps(plant)
    else:
        sys.exit(f"{rival}: unknown")
    np.save(f"{folder}/theirs.npy", tails)
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
    print(seconds, peak, prepared, gap)


main()
