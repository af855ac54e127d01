"""The stages of the cable pipeline, one module each, in the order of the data; see run.py."""
