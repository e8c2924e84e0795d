"""A plume as a smoke simulation leaves it: one grid `density` without unit, origin and voxel of its own."""
import numpy as np
import pyopenvdb as vdb

n = (56, 40, 24)
rng = np.random.default_rng(20261125)
axes = np.meshgrid(*[np.arange(k) for k in n], indexing="ij")
density = np.zeros(n)
for _ in range(90):
    height = rng.uniform(2, n[1] - 4)
    spread = 2.0 + 0.22 * height
    centre = (12 + 0.75 * height + rng.normal(0, spread), height, n[2] / 2 + rng.normal(0, 0.6 * spread))
    radius = rng.uniform(1.2, 1.5 + 0.09 * height)
    squares = sum((axis - c) ** 2 for axis, c in zip(axes, centre))
    density += rng.uniform(0.3, 1.0) * np.exp(-squares / (2 * radius**2))
density[density < 0.02] = 0.0
grid = vdb.FloatGrid()
grid.copyFromArray(density.astype(np.float32), tolerance=1e-6)
grid.name = "density"
grid.gridClass = vdb.GridClass.FOG_VOLUME
grid.transform = vdb.createLinearTransform(voxelSize=1.5)
grid.transform.translate((-40.0, 0.5, -78.0))
grid.saveFloatAsHalf = True
vdb.write("plume.vdb", grids=[grid], metadata={"creator": "make_plume.py"})
