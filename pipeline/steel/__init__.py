"""Large steel structures from many laser scans and photos, after Guo Ming et al. 2021.

The map; :mod:`pipeline.steel.run` holds the order, ``station_stages`` and ``chain`` what is made from
what, ``options`` every option.

- the survey: ``survey``, ``survey_records``
- a station: ``clouds`` (``cloud_readers``), ``targets`` (``range_image``, ``spheres``, ``sphere_fit``),
  ``target_table``
- all stations: ``naming`` (``pattern``), ``register``: first ``network``, ``station_checks``, then starting
  values by ``approximate`` (``rodrigues``, ``unplaced``), one adjustment by ``adjustment`` (``state``,
  ``conditions``, ``equations``), weights and gross errors by ``variance`` and ``gross``; beside it
  ``chained`` and ``icp``
- the registered cloud: ``tiles`` (``tile_reader``), ``members``: search by ``oriented``, ``segments``,
  ``joining``, ``meeting``, ``balls``, ``rods``; fits to ranges by ``rays``, ``fitting``, ``common_radius``,
  ``shares``
- what is asked for: ``nodes`` (``perpendiculars``), ``columns``, ``deflection``
- photos: ``photo_model`` (``photo_sparse``, ``photo_targets``, ``photo_depth``, ``photo_dense``), ``fuse``:
  start by ``feature_match``, ``photo_spheres`` or ``cable_start``, then ``point_match`` on
  ``scanned_surface``, ``fuse_sigma``
- records: ``records`` (stations and features), ``registration_records``, ``member_records``,
  ``fuse_records``, ``steel_run`` (everything found)
"""
