"""What every stage may use; knows nothing of stages, imports nothing from outside this folder.

- Words: ``vocabulary`` (Lens, Poses, PosPriors, FrameSequence, frames of reference), ``errors`` (StageError,
  the one error a person can act on), ``events`` (progress, through which a run is also cancelled).
- Geometry: ``rotations`` (POS angles, nominal poses), ``division`` (the lens), ``axis`` (a curved axis and
  unrolled coordinates), ``epipolar``, ``fundamental``, ``mesh``.
- Fits, all to distances: ``fits/`` (line, circle, ellipse, cylinder, sphere, similarity, robust weights).
- Adjustment: ``rig`` (what is adjusted and observed), ``normals`` (reduced normal equations), ``bundle``
  (Levenberg-Marquardt with priors and covariance), ``smooth_surface`` (a weak prior on the surface).
- Run: ``options`` (frozen records from TOML and from words), ``files`` (results appear whole or not at all),
  ``store`` (records to one file and back, stamps), ``runfolder`` (what is finished is kept).
"""
