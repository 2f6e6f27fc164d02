"""What the arguments of public callables take of the strange values, and what is known to fail."""

from __future__ import annotations

__all__ = ["ADMITTED", "ARRAYS", "KNOWN", "NUMBERS_OF_LAWS", "TAKEN"]

TEXTS = {"text", "word", "empty text", "long text", "null byte"}
FUNCTIONS = {"function", "raising function", "class"}
ARRAYS = {"empty list", "list of nan", "nested", "three", "array", "one element", "inf matrix", "no rows"}

# By parts of an annotation. None is admitted where the annotation has it, texts where it has texts, and so on.
# Methods whose arguments have no annotation that tells.
NUMBERS_OF_LAWS = ("force", "stiffness", "energy", "indentation", "force_at_angle")

ADMITTED: dict[str, set[str]] = {
    "None": {"none"},
    "Any": {"none", *FUNCTIONS},
    "bool": {"true"},
    "str": TEXTS,
    "PathLike": TEXTS,
    "Callable": FUNCTIONS,
    "Motion": FUNCTIONS,
    "Signal": FUNCTIONS,
    "LcpSolver": FUNCTIONS,
    "ArrayLike": ARRAYS,
    "Place": {"three"},  # of points of spatial bodies
    "FloatArray": ARRAYS,
    "NDArray": ARRAYS,
    "Sequence": {"empty list", "no rows"},
    "Interfaces": {"empty list", "no rows", "one element"},
    "Damping": {"one element"},
    "Mapping": {"empty dict"},
    "Near": {"empty dict"},  # of solids
    "Sequence[float]": {"three", "array", "one element"},
    "tuple[float, ...]": {"three", "array", "one element"},
    "Sequence[str]": {"list of word", "list of texts"},
    "tuple[str, str]": {"list of texts"},
    "Body": {"body"},
    "Scene": {"scene"},
    "Stepper": {"stepper"},
}

ANYTHING = {
    *("empty list", "list of nan", "list of texts", "list of word", "huge numbers", "complex array", "object array"),
    *("bool array", "date array", "text array", "record array", "one element", "no rows", "inf matrix"),
}
LABELS = {"list of texts", "list of word", "text array", "empty list", "no rows", "dict", "empty dict"}
ENDLESS = {"10^400", "10^5000"}  # as infinity, or as a count without end

# By callable and argument, for reasons of their own.
TAKEN: dict[tuple[str, str], set[str]] = {
    ("EventDriven", "max_step"): ENDLESS,
    ("AdaptiveStep", "longest"): ENDLESS,
    ("ExplicitRungeKutta", "max_step"): ENDLESS,
    ("Stiff", "max_step"): ENDLESS,
    ("accept", "iterations"): ENDLESS,
    ("accept", "active"): {"array", "one element"},  # of an LCP behind the problem, whose size is another
    ("MixedLcp", "free"): {"bool array"},
    ("ContactProblem", "keys"): ANYTHING,
    ("SpatialContactProblem", "keys"): ANYTHING,
    ("Continuum", "sets"): {"dict"},  # "a" is node 1
    ("SolidOfRevolution", "sets"): {"dict"},
    ("Matrices", "node_sets"): {"dict"},
    ("SpatialMatrices", "node_sets"): {"dict"},
    ("Solid", "sets"): {"dict"},
    ("Solid.box", "elements"): {"three"},
    ("Solid.bar", "elements"): {"three"},
    ("matrices_from_files", "node_sets"): {"dict"},
    ("matrices_from_files in space", "node_sets"): {"dict"},
    ("Force", "P"): {"strange point"},  # the scene is known when it is loaded with the force
    ("Force in space", "value"): {"three"},
    ("Torque in space", "value"): {"three"},
    ("Torque", "P"): {"strange point"},
    ("Point", "P"): {"strange point"},  # as with sensors
    **{(sensor, "body"): {"stranger"} for sensor in ("Body", "Section", "Stress")},
    ("Coordinates", "names"): {"list of texts", "list of word", "text array"},  # scenes tell which names there are
    ("Function", "columns"): {"list of texts", "list of word", "text array"},
    ("Function", "units"): {"list of word"},
    ("advice.contact_advice", "half_section"): {"true"},
    ("stability", "truth"): {"true", "stepper"},
    ("right_size", "stepper"): {"stepper"},
    ("Result.verify", "stepper"): {"stepper"},  # that of the result
    ("outcome_legend", "curves"): {
        "list of texts",
        "list of word",
        "text array",
        "empty list",
        "no rows",
        "dict",
        "empty dict",
    },
    ("RecordProblems", "every"): ENDLESS,
    ("RecordProblems", "hardest"): ENDLESS,
    ("RecordProblems", "limit"): ENDLESS,
    ("advice.effective", "first"): ENDLESS,
    ("advice.effective", "second"): ENDLESS,
}

# By callable and argument: one of the values with which the call does not end as it should.
KNOWN: dict[tuple[str, str], str] = {}
