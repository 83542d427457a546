"""Names that are typed but are none: misspelt ones, symbols and other programs' words, and what is not modelled."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator

MEANT = (
    ("young_modulus", "Young's modulus", "E elastic_modulus modulus"),
    ("poisson_ratio", "Poisson's ratio", "nu v poisson"),
    ("yield_stress", "the yield stress", "yield sigma_y Sy Re Rp02"),
    ("friction", "the coefficient of friction", "mu COF f friction_coefficient coefficient_of_friction"),
    ("coefficient", "the coefficient of friction", "mu COF f"),
    ("radius", "the radius", "R r"),
    ("surface", "the shape", "geometry shape profile"),
    ("heights", "a map of a rough surface", "map scan topography"),
    ("roughness", "a rough surface by its spectrum", "rough Ra Rq Sa Sq"),
    ("hurst", "the Hurst exponent", "H hurst_exponent"),
    ("rms_height", "the root mean square height", "Rq Sq rms"),
    ("rms_slope", "the root mean square slope", "Rdq Sdq slope"),
    ("load_path", "the load path", "steps stages loads loading history"),
    ("P", "the normal force", "N F Fn Fz W load force normal_force normal_load"),
    ("delta_z", "the approach", "delta uz approach indentation penetration"),
    ("Qx", "the tangential force along x", "Q T Ft Fx tangential_force shear_force"),
    ("delta_x", "the displacement along x", "u ux displacement"),
    ("Mz", "the torque", "torque"),
    ("points", "the number of cells per side", "n nx cells resolution"),
    ("increments", "the number of increments", "n steps substeps n_steps num_steps"),
    ("times", "the number of repetitions", "N cycles n_cycles repeat repetitions"),
    ("tolerance", "the tolerance", "tol"),
    ("stiffness_x", "the rig's stiffness along x", "k kt kx k_t k_x stiffness system_stiffness"),
    ("stiffness_z", "the rig's stiffness along the normal", "kn kz k_n k_z normal_stiffness"),
    ("rig", "what gives between contact and actuator", "spring springs machine system test_rig"),
    ("shear_compliance", "the layer's displacement per shear traction", "compliance stiffness kt k"),
    ("interface", "a layer between the bodies", "layer film third_body oxide asperities"),
    ("actuator_x", "the displacement of the actuator along x", "actuator stroke"),
)
"""Keys, what they are, and other names for them."""

UNKNOWN_TO_THE_MODEL = {
    "G shear_modulus": "young_modulus is 2 G (1 + poisson_ratio)",
    "thickness height depth width length specimen": (
        "bodies are half-spaces, without a thickness or sides. A rigid base 10 contact radii below a sphere lessens the"
        " approach by 5 to 8 % and raises the largest pressure by less than 0.1 %; a base 3 radii below by 17 to 25 %"
        " and 1 to 2 %. A thin layer between the bodies is interface, with a thickness and moduli"
    ),
    "coating coatings layers": (
        "bodies are uniform, and coatings are not modelled, but interface has a thin layer that yields at each place by"
        " the traction there alone. A coating of thickness t and Young's modulus E is compressed by"
        " at most p t/E, which has to be small against delta_z; if it is stiffer than the body, t has to be small"
        " against the contact radius"
    ),
    "plasticity plastic hardening hardening_modulus": (
        "bodies are elastic, and plastic flow is not modelled. yield_stress warns where it begins: under a sphere at a"
        " largest pressure of 1.6 times the yield stress, at the surface at a shear of 0.58 times the yield stress"
    ),
    "lubricant lubrication lubricated oil grease viscosity": (
        "the contact is dry; a lubricant is modelled by its coefficient of friction alone"
    ),
    "adhesion surface_energy work_of_adhesion": (
        "adhesion is not modelled. It is felt where 3/2 pi w R, the pull-off force of a sphere (w: work of adhesion),"
        " is not small against P"
    ),
    "temperature thermal heat thermal_expansion conductivity": "heat and thermal expansion are not modelled",
    "velocity speed slip_rate frequency time period density mass damping": (
        "the solution is quasi-static, without velocity, time or inertia; the load path is a list of stages"
    ),
    "creep viscoelastic viscoelasticity relaxation": "bodies are elastic: creep and relaxation are not modelled",
    "debris": (
        "debris is not modelled: wear removes what it wears. interface has a layer of debris that shears and is"
        " compressed, with a constant compliance"
    ),
}
"""Names of what no key gives, and why, with the place from which it matters."""


ALIKE, MISSPELT = 0.7, 0.85
"""Share of letters in common from which a name may be meant, and from which it is so even if it is another name."""


def nearest(name: str, allowed: Collection[str]) -> str:
    """Return a hint for a name that is not among the `allowed`: the likely one, or all of them."""
    meant = close_name(name, allowed)
    return f"did you mean {meant!r}?" if meant else f"one of {', '.join(allowed)} is needed"


def close_name(name: str, allowed: Iterable[str], alike: float = ALIKE) -> str | None:
    """Return the name among the `allowed` that `name` nearly spells, in any case; None if there is none.

    alike: least share of letters in common.
    """
    by_lower = {candidate.lower(): candidate for candidate in allowed}
    import difflib  # for cases with a mistake

    return next((by_lower[match] for match in difflib.get_close_matches(name.lower(), by_lower, 1, cutoff=alike)), None)


def meant_by(name: str) -> Iterator[tuple[str, str]]:
    """Yield the keys that a name may stand for, each with what it is. Symbols have their case, words have not."""
    spelt = str if len(name) == 1 else str.lower
    yield from ((key, noun) for key, noun, words in MEANT if spelt(name) in map(spelt, words.split()))


def key_meant(name: str, allowed: Collection[str]) -> str | None:
    """Return the key among the `allowed` for which `name` is another name."""
    return next((key for key, _ in meant_by(name) if key in allowed), None)


def not_modelled(name: str) -> str | None:
    """Return why there is no such key, None where nothing is known of the key."""
    found = (reason for words, reason in UNKNOWN_TO_THE_MODEL.items() if name.lower() in words.lower().split())
    return next(found, None)
