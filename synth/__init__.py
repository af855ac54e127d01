"""Synthetic cables with known truth: spec, truth, scene, lens camera, render, video."""
