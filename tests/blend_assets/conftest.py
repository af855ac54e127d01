"""The asset library, built once for the session."""

import pytest

from blend_assets.build import build


@pytest.fixture(scope="session")
def library(tmp_path_factory):
    """The folder of a freshly built library."""
    return build(tmp_path_factory.mktemp("assets"))
