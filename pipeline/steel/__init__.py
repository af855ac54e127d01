"""Large steel structures from many laser scans and photos, after Guo Ming et al. 2021.

The map; :mod:`pipeline.steel.run` holds the order, ``station_stages`` and ``chain`` what is made from
what, ``options`` every option.

- the survey: ``survey``, ``survey_records``
- a station: ``clouds`` (``cloud_readers``, ``cloud_texts``), ``station_features``: ``targets``
  (``range_image``, ``spheres``, ``sphere_fit``; ``planes``, ``plane_fit``; ``axes``), ``target_table`` and
  ``name_table`` (``csv_rows``)
- all stations: ``naming`` (``pattern``), then ``figure_register``, which names axes and planes (``figures``)
  once targets have placed the stations; ``register``: first ``network``, ``station_checks``, then starting
  values by ``approximate`` (``rodrigues``, ``figure_start``, ``unplaced``), one adjustment by ``adjustment``
  (``state``, ``conditions``, ``equations``), weights and gross errors by ``variance``, ``point_shape`` and
  ``gross``; beside it ``chained`` and ``icp``
- the registered cloud: ``tiles`` (``tile_reader``), ``members``: search by ``oriented``, ``segments``,
  ``joining``, ``meeting``, ``balls``, ``rods``; fits to ranges by ``rays``, ``fitting``, ``common_radius``,
  ``shares``; ``vectors``
- what is asked for: ``nodes`` (``perpendiculars``, ``straightness``), ``columns``, ``deflection``
  (``support_plane``), their covariances by ``joint``
- photos: ``photo_model`` (``photo_sparse``, ``photo_features``, ``photo_mapping``, ``photo_targets``,
  ``photo_dense``, ``photo_depth``, ``photo_correlation``, ``photo_points``), ``fuse``:
  start by ``feature_match`` (``triangles``), ``photo_spheres`` or ``cable_start`` (``cable_shift``), then
  ``point_match`` on ``scanned_surface``, ``fuse_rivals``, ``fuse_sigma``
- records: ``records`` (stations and features), ``registration_records``, ``member_records``,
  ``fuse_records``, ``steel_run`` (everything found)
"""
