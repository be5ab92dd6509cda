"""Modified Cam-Clay fitted to a triaxial test: the laboratory's curve is that of the law with noise, so that the answer is known.

Gauss–Newton steps with differences of the driven path; a step is a handful of paths of one point, a millisecond each.
"""

import numpy as np

import implicit_mpm as mpm

KNOWN = {"critical_ratio": 1.05, "compression": 0.12, "swelling": 0.025}


def curve(parameters: dict[str, float]) -> np.ndarray:
    """Deviatoric stress q along a drained triaxial compression [kPa]."""
    path = mpm.drive(
        {
            "law": {"CamClay": {**parameters, "shear": 2000, "reference_pressure": 50, "preconsolidation": 120}},
            "stress": (-100, -100, -100),
            "path": [{"Triaxial": {"by": -0.2, "steps": 40}}],
        }
    )
    return np.asarray(path["q"])


def main() -> None:
    measured = curve(KNOWN) + np.random.default_rng(1).normal(scale=0.2, size=41)
    names = list(KNOWN)
    found = np.array([0.8, 0.2, 0.04])
    for iteration in range(6):
        at = curve(dict(zip(names, found)))
        residual = measured - at
        slopes = np.empty((len(at), len(found)))
        for k, value in enumerate(found):
            other = found.copy()
            other[k] = value * (1 + 1e-6)
            slopes[:, k] = (curve(dict(zip(names, other))) - at) / (1e-6 * value)
        step = np.linalg.lstsq(slopes, residual, rcond=None)[0]
        # No parameter changes by more than a third at once.
        found = found + step * min(1.0, *(found / 3 / np.maximum(abs(step), 1e-30)))
        print(f"{iteration}: misfit {np.sqrt(np.mean(residual**2)):.3f} kPa, " + ", ".join(f"{n} {v:.4f}" for n, v in zip(names, found)))
    assert np.allclose(found[:2], [KNOWN["critical_ratio"], KNOWN["compression"]], rtol=0.05)


if __name__ == "__main__":
    main()
