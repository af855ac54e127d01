"""Large steel structures from many laser scans and photos, after Guo Ming et al. 2021; see run.py."""
