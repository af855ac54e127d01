"""The written run that all tests here look at."""

import pytest

from tests.evaluate.written_run import write_case


@pytest.fixture
def case(tmp_path):
    """A function that writes a run and its truth, with errors as asked, and gives both paths."""

    def write(**errors):
        return write_case(tmp_path, **errors)

    return write
