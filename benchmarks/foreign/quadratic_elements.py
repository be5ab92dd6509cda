"""Time against error of quadratic finite elements (scikit-fem), on the problems of `mpm-benchmarks -- error`.

    python3 -m venv target/foreign && target/foreign/bin/pip install scikit-fem scipy
    OMP_NUM_THREADS=1 target/foreign/bin/python benchmarks/foreign/quadratic_elements.py [FILE.json] [--quick]
    OMP_NUM_THREADS=1 target/foreign/bin/python benchmarks/foreign/quadratic_elements.py --column CELLS STEPS [YOUNG]

Nine-node quadrilaterals fitted to the bodies, total Lagrangian, Hencky's law with its exact tangent, sparse LU of scipy. Each problem takes the
fewest load steps of 1, 2, 5, 10, 20, 40 with which Newton's method converges. Errors are measured as in the set `error`; seconds are those of the
processor from the mesh to the answer, the least of three. With `--column` there is one run of the column alone, the hard one unless Young's modulus is
given, to be timed as a whole process; it prints the mean error of the vertical stress.
"""

import json
import sys
import time

import numpy as np
import skfem
from scipy.sparse.linalg import splu
from skfem import BilinearForm, Basis, ElementQuad2, ElementVector, LinearForm, MeshQuad, MeshQuad2


class Body:
    """A body of nine-node quadrilaterals under dead loads and prescribed displacements."""

    def __init__(self, mesh, young, poisson, element=ElementVector(ElementQuad2())):
        self.basis = Basis(mesh, element, intorder=4)
        self.bulk = young / (3 * (1 - 2 * poisson))
        self.shear = young / (2 * (1 + poisson))

    def stress(self, grad):
        """Second Piola–Kirchhoff stress and its derivative by Green's strain, `[2, 2, …]` and `[2, 2, 2, 2, …]`; Kirchhoff's stress."""
        f = np.eye(2)[:, :, None, None] + grad
        c = np.einsum("kiab,kjab->ijab", f, f)
        squares, axes = np.linalg.eigh(np.moveaxis(c, (0, 1), (2, 3)))
        # Equal stretches are parted by rounding: the quotient below then keeps eight digits.
        squares[..., 1] += 1e-8 * (squares[..., 1] - squares[..., 0] < 1e-8)
        strain = 0.5 * np.log(squares)
        volumetric, tau = strain.sum(-1), 2 * self.shear * strain
        tau += (self.bulk - 2 * self.shear / 3) * volumetric[..., None]
        s = tau / squares
        d = (self.bulk - 2 * self.shear / 3) + 2 * self.shear * np.eye(2)
        normal = (d - 2 * np.einsum("ab,...a->...ab", np.eye(2), tau)) / (squares[..., :, None] * squares[..., None, :])
        across = (s[..., 1] - s[..., 0]) / (squares[..., 1] - squares[..., 0])
        n = axes
        second = np.einsum("...a,...ia,...ja->ij...", s, n, n)
        tangent = np.einsum("...ab,...ia,...ja,...kb,...lb->ijkl...", normal, n, n, n, n)
        shear = np.einsum("...i,...j->...ij", n[..., 0], n[..., 1])
        shear = shear + np.swapaxes(shear, -1, -2)
        tangent += np.einsum("...,...ij,...kl->ijkl...", across, shear, shear)
        return f, second, tangent, np.einsum("ikab,klab,jlab->ijab", f, second, f)

    def assemble(self, u):
        f, second, tangent, _ = self.stress(self.basis.interpolate(u).grad)
        moduli = np.einsum("ikab,kjlmab,nlab->ijnmab", f, tangent, f)
        moduli += np.einsum("in,jmab->ijnmab", np.eye(2), second)
        first = np.einsum("ikab,kjab->ijab", f, second)
        stiffness = BilinearForm(lambda u, v, w: np.einsum("ijnmab,ijab,nmab->ab", moduli, v.grad, u.grad))
        force = LinearForm(lambda v, w: np.einsum("ijab,ijab->ab", first, v.grad))
        return stiffness.assemble(self.basis), force.assemble(self.basis)

    def solve(self, prescribed, load, steps):
        """Displacement at full load: `prescribed(t)` gives degrees of freedom and values, `load(t)` the force. None without convergence."""
        u = np.zeros(self.basis.N)
        held = prescribed(0.0)[0]
        free = np.setdiff1d(np.arange(self.basis.N), held)
        for t in np.arange(1, steps + 1) / steps:
            _, values = prescribed(t)
            jump = np.zeros_like(u)
            jump[held] = values - u[held]
            external = load(t)
            for iteration in range(20):
                stiffness, force = self.assemble(u)
                out = external - force
                scale = max(np.linalg.norm(external), np.linalg.norm(force), 1e-300)
                if iteration and np.linalg.norm(out[free]) <= 1e-10 * scale:
                    break
                right = (out - stiffness @ jump)[free]
                du = jump.copy()
                du[free] = splu(stiffness[free][:, free].tocsc()).solve(right)
                u, jump = u + du, np.zeros_like(u)
                if not np.isfinite(u).all() or self.is_inside_out(u):
                    return None
            else:
                return None
        return u

    def is_inside_out(self, u):
        grad = self.basis.interpolate(u).grad
        return ((1 + grad[0, 0]) * (1 + grad[1, 1]) - grad[0, 1] * grad[1, 0]).min() <= 0


def components(basis):
    """Component of each degree of freedom."""
    of = np.zeros(basis.N, dtype=int)
    for dofs in (basis.nodal_dofs, basis.facet_dofs, basis.interior_dofs):
        for row in range(dofs.shape[0]):
            of[dofs[row]] = row % 2
    return of


def column(cells, young, steps):
    width = 50 / cells
    body = Body(MeshQuad.init_tensor([0, width], np.linspace(0, 50, cells + 1)), young, 0.0)
    x, component = body.basis.doflocs, components(body.basis)
    held = np.flatnonzero((component == 0) | (x[1] < 1e-9))
    weight = LinearForm(lambda v, w: -800.0 * v.value[1]).assemble(body.basis)
    u = body.solve(lambda t: (held, 0.0), lambda t: t * weight, steps)
    if u is None:
        return None
    field = body.basis.interpolate(u)
    f, _, _, tau = body.stress(field.grad)
    height = body.basis.global_coordinates().value[1]
    error = np.abs(tau[1, 1] / np.linalg.det(np.moveaxis(f, (0, 1), (2, 3))) + 800 * (50 - height))
    return (error * body.basis.dx).sum() / (800 * 50 * body.basis.dx.sum())


def ring(radii, sectors):
    """A ring of curved nine-node quadrilaterals, closed."""
    flat = MeshQuad.init_tensor(radii, np.linspace(0, 2 * np.pi, sectors + 1))
    places = np.array([flat.p[0] * np.cos(flat.p[1]), flat.p[0] * np.sin(flat.p[1])])
    # Both ends of the circle are one.
    _, first, number = np.unique(np.round(places, 9), axis=1, return_index=True, return_inverse=True)
    straight = MeshQuad2.from_mesh(MeshQuad(places[:, first], number.reshape(-1)[flat.t]))
    # Middles of chords go out to their circles.
    half = np.pi / sectors
    at = np.arctan2(straight.doflocs[1], straight.doflocs[0]) / (2 * half)
    between = np.abs(at - np.round(at)) > 0.25
    return MeshQuad2(straight.doflocs / np.where(between, np.cos(half), 1.0), straight.t)


def doughnut(cells, steps):
    mesh = ring(np.linspace(5, 10, cells[0] + 1), cells[1])
    body = Body(mesh, 1e6, 0.0)
    x, component = body.basis.doflocs, components(body.basis)
    radius = np.hypot(*x)
    inner, outer = np.flatnonzero(radius < 5 + 1e-6), np.flatnonzero(radius > 10 - 1e-6)
    held = np.concatenate([inner, outer])

    def turned(t):
        angle = np.radians(20) * t
        sin, cos = np.sin(angle), np.cos(angle)
        moved = np.where(component == 0, (cos - 1) * x[0] - sin * x[1], sin * x[0] + (cos - 1) * x[1])
        return held, np.concatenate([moved[inner], 0 * outer])

    u = body.solve(turned, lambda t: np.zeros(body.basis.N), steps)
    if u is None:
        return None
    _, force = body.assemble(u)
    angle = np.radians(20)
    where = np.array([np.cos(angle) * x[0] - np.sin(angle) * x[1], np.sin(angle) * x[0] + np.cos(angle) * x[1]])
    torque = sum((where[0, k] if component[k] == 1 else -where[1, k]) * force[k] for k in inner)
    return abs(torque / 6.7643365e7 - 1)


def vortex(cells, steps):
    body = Body(ring(np.linspace(0.75, 1.25, cells + 1), 16 * cells), 1e3, 0.3)
    basis = body.basis
    x, component = basis.doflocs, components(basis)
    radius = np.hypot(*x)
    held = np.flatnonzero((radius < 0.75 + 1e-6) | (radius > 1.25 - 1e-6))
    places = basis.global_coordinates().value
    rest = np.hypot(*places)

    def exact(t):
        amplitude, s = 0.25 * t, rest - 1
        turn = amplitude * (1 - 32 * s**2 + 256 * s**4)
        first, second = -64 * s + 1024 * s**3, -64 + 3072 * s**2
        return turn, amplitude * rest * first, amplitude * (first + rest * second)

    def load(t):
        turn, gamma, slope = exact(t)
        h, root = np.arcsinh(gamma / 2), np.sqrt(1 + gamma**2 / 4)
        quotient = 0.5 / root**2 - 0.25 * h * gamma / root**3
        radial = body.shear * (slope * (h / root + gamma * quotient) + 2 * h * gamma / (root * rest))
        hoop = -2 * body.shear * (slope * quotient + 2 * h / (root * rest))
        cos, sin = np.cos(turn) * places[0] - np.sin(turn) * places[1], np.sin(turn) * places[0] + np.cos(turn) * places[1]
        cos, sin = cos / rest, sin / rest
        force = np.array([radial * cos - hoop * sin, radial * sin + hoop * cos])
        return LinearForm(lambda v, w: force[0] * v.value[0] + force[1] * v.value[1]).assemble(basis)

    u = body.solve(lambda t: (held, 0.0), load, steps)
    if u is None:
        return None
    turn = exact(1.0)[0]
    moved = np.array(
        [(np.cos(turn) - 1) * places[0] - np.sin(turn) * places[1], np.sin(turn) * places[0] + (np.cos(turn) - 1) * places[1]]
    )
    off = basis.interpolate(u).value - moved
    return np.sqrt(((off**2).sum(0) * basis.dx).sum() / ((moved**2).sum(0) * basis.dx).sum())


def cantilever(factor, steps):
    mesh = MeshQuad.init_tensor(np.linspace(0, 10, 20 * factor + 1), np.linspace(9, 10, 2 * factor + 1))
    body = Body(mesh, 12e6, 0.2)
    basis = body.basis
    held = np.flatnonzero(basis.doflocs[0] < 1e-9)
    tip = basis.probes(np.array([[9.75], [9.5]]))
    down = tip.tocsr()[[1]].toarray().ravel() * -100e3
    u = body.solve(lambda t: (held, 0.0), lambda t: t * down, steps)
    if u is None:
        return None
    outer = (basis.global_coordinates().value[0] > 9.5) * basis.dx
    end = (basis.interpolate(u).value * outer).sum((1, 2)) / outer.sum()
    known = np.array([-5.2946, -7.9959])
    return np.linalg.norm(end - known) / np.linalg.norm(known)


PROBLEMS = {
    "column, hard": (lambda n, steps: column(n, 1e4, steps), [2, 4, 8, 16, 32, 64, 128]),
    "column, mild": (lambda n, steps: column(n, 1e6, steps), [2, 4, 8, 16, 32, 64, 128]),
    "cantilever": (cantilever, [1, 2, 3, 4]),
    "doughnut twist, elastic": (lambda k, steps: doughnut((2 * k, 12 * k), steps), [1, 2, 3, 4, 6, 8]),
    "generalised vortex": (vortex, [2, 3, 4, 6, 8, 12]),
}


def main():
    if "--column" in sys.argv:
        cells, steps, young = (*sys.argv[sys.argv.index("--column") + 1 :], "1e4")[:3]
        error = column(int(cells), float(young), int(steps))
        if error is None:
            sys.exit(f"Newton's method does not converge on {cells} cells in {steps} load steps")
        print(f"mean stress error {error:.6e}")
        return
    quick = "--quick" in sys.argv
    rows = []
    for name, (solve, meshes) in PROBLEMS.items():
        for mesh in meshes[:2] if quick else meshes:
            steps = next((n for n in (1, 2, 5, 10, 20, 40) if solve(mesh, n) is not None), None)
            if steps is None:
                rows.append({"problem": name, "mesh": mesh, "error": None})
                continue
            seconds = []
            for _ in range(1 if quick else 3):
                begun = time.process_time()
                error = solve(mesh, steps)
                seconds.append(time.process_time() - begun)
            rows.append({"problem": name, "mesh": mesh, "steps": steps, "error": error, "seconds": min(seconds)})
            print(f"{name:24} {mesh:4} {steps:3} steps {error:10.3e} {min(seconds):9.4f} s", flush=True)
    files = [argument for argument in sys.argv[1:] if not argument.startswith("--")]
    if files:
        with open(files[0], "w") as file:
            json.dump({"program": f"scikit-fem {skfem.__version__}", "rows": rows}, file, indent=1)


if __name__ == "__main__":
    main()
