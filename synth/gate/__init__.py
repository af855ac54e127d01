"""The gate of accuracy (``make accuracy``): two small surveys whose figures must lie between two bounds."""
