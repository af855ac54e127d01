"""CableTwin's pipeline: from the videos of a cable-climbing robot to a measured, textured model; from laser
scans and photos of a steel structure to its nodes, columns and deflection.

The map.  ``python -m pipeline run SURVEY.toml --out RUN`` goes through one call,
:func:`pipeline.product.make_product`: the stages, then everything a person opens.

The stages (``cable/``, one module each, in this order; :mod:`pipeline.cable.run` holds the order,
``block_stages`` and ``ring_stages`` what is made from what):

=========  ==================================================  =============================================
stage      takes                                               gives
=========  ==================================================  =============================================
survey     survey.toml                                         cable, robot, cameras, as the user wrote them
frames     videos or pictures                                  the frames worked on, in the order of travel
*then, block by block*
lens       frames, the lens as stated                          division lens from plumb lines
pos        robot, travel, or a POS file                        what is known of each frame's pose
match      frames, lens, pos                                   tie points along the strip
adjust     tie points, lens, pos                               poses, points and lens of the block alone
*the ring, where the cameras share a clock*
closing    frames, adjusted blocks                             marks that neighbouring blocks share
joint      adjusted blocks, shared marks, robot                all blocks as one rig, with one covariance
*block by block again*
undistort  frames, adjusted lens                               flat frames, for people and other programs
dense      frames, poses, lens                                 a radius for every cell of the surface
surface    radius map                                          the same without gross errors
texture    frames, surface                                     the unrolled picture
crop       surface                                             which cells are kept: not the limb
*all blocks*
mosaic     surfaces, pictures (or pairs chosen by hand)        every block's place in one model
ring       placed blocks                                       the closed surface about a straight axis
measure    ring, covariance, stations                          diameters with sigma, axis, relief
report     everything found                                    RUN/report.html, report.json, model, tables
=========  ==================================================  =============================================

Products of the stages lie in RUN/products, stamped with what they were made from: a run that is started again
makes what is missing or has changed, nothing else (:mod:`pipeline.core.runfolder`).

The second system (``steel/``), ``python -m pipeline steel SURVEY.toml --out RUN``, through
:func:`pipeline.steel_product.make_steel_product`:

=========  ==================================================  =============================================
stage      takes                                               gives
=========  ==================================================  =============================================
survey     survey.toml of kind steel                           scanner, targets, stations, columns, limits
*station by station*
clouds     E57, LAS, LAZ, PLY, PTS, XYZ                        points in the station frame
targets    points, or a table written by hand                  sphere targets, planes, axes with covariance
*all stations*
register   targets                                             names, poses, one covariance, gross errors
compare    targets, points                                     the same station by station and by ICP
tiles      points, poses                                       the registered points, in cubes on disk
members    tiles                                               rods, columns, ball nodes
measure    members                                             eccentricities, inclinations, deflection
report     everything found                                    RUN/report.html, report.json, model, tables
=========  ==================================================  =============================================

The other rooms:

- ``segments/``: surveys too long for one piece, worked off segment by segment in bounded memory.
- ``core/``: shared words, geometry, lens, fits, adjustment, files, run folder; knows no stage.
- ``report/``: tables, plots, the page, the exported files; computes nothing twice.
- ``scan/``: a laser scan of a cable in the frame of its finished run (``python -m pipeline join-scan``).
- ``evaluate/``: a run against the truth, and against stock COLMAP on the same frames.
- ``opened``, ``joining``, ``copies``: a run folder read back, blocks joined anew by hand, files handed on.
- ``progress``, ``console``: how far a run is, for programs and people.
- ``set_aside``: what an earlier run left never passes for the result of one that was refused.

Nothing here imports ``synth`` (which renders surveys with known truth), ``addon`` or ``bpy``.
"""
