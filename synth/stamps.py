"""Which specification a rendered folder belongs to: one stamp for its pictures, one for what is told of them.

Pure: takes a specification, gives texts.  The claims of ``[survey]`` and the name change no pixel, so
scenarios that differ in nothing else share their pictures, and changed claims rewrite survey.toml and
truth.json alone.
"""

import hashlib
import json

from synth.spec import Spec
from synth.spec_reader import effective

PICTURES_VERSION = 1  # raise it when the same specification gives other pictures
CLAIMS_VERSION = 2  # raise it when the same specification gives another survey.toml or truth.json

WORK = ".synth"
PICTURES = f"{WORK}/stamp"
CLAIMS = f"{WORK}/claims"
"""Files of the two stamps inside a rendered folder."""


def pictures_stamp(spec: Spec) -> str:
    """Digest of everything that the pictures hang on."""
    shown = {key: value for key, value in effective(spec).items() if key not in ("name", "survey")}
    return _digest([PICTURES_VERSION, shown])


def claims_stamp(spec: Spec) -> str:
    """Digest of everything that survey.toml and truth.json hang on."""
    return _digest([CLAIMS_VERSION, effective(spec)])


def _digest(value: object) -> str:
    return hashlib.sha256(json.dumps(value, sort_keys=True).encode()).hexdigest()
