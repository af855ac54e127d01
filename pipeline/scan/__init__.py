"""A laser scan of a cable and its photo model: ``python -m pipeline join-scan RUN --scan CLOUD``.

The map: ``finished`` reads the run, ``reading`` the scan, in which ``tube`` finds the cable and ``limb`` its
limb, ``pairs`` places pointed out in both; ``join`` brings the scan into the cable frame through
:func:`pipeline.steel.fuse.fuse` and compares; ``held`` says what the fit can know; ``product`` writes all.
"""
