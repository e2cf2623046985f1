"""How deep the scene is from each of the world's cameras, and what a frame costs there.

    RAXEL=target/release/raxel PYTHONPATH=python python3 python/examples/depth_profile.py

The cells (# %%) run one by one in editors that know notebooks.
"""

# %% Open a graph over a world; nothing has run yet.
import raxel

session = raxel.open("graphs/inspect.toml", world="worlds/menger.toml", size=(320, 180))
info = session.info()
print(info["device"], "shows", info["graph"], "with the params", [param["name"] for param in info["params"]])

# %% The sky is at 1000 voxels, so that it can be told from the scene.
session.set("sky_depth", 1000.0)

# %% From each camera: nearest, median and farthest hit, and the milliseconds of the passes.
for camera in [None, *info["cameras"]]:
    if camera is not None:
        session.camera(camera)
    session.step()
    depth = session.texels("depth")
    hits = sorted(value for row in depth.tolist() for (value,) in row if value < 1000.0)
    if hits:
        print(f"{camera or 'first'}: {hits[0]:.1f} … {hits[len(hits) // 2]:.1f} … {hits[-1]:.1f} voxels,", session.timings())

# %% Move closer in ten steps and watch the pixel in the middle.
position = session.camera()["position"]
for step in range(10):
    session.camera(position=[position[0], position[1], position[2] - step])
    session.step()
    print(step, session.pixel("depth", 160, 90))

# %% Done.
session.close()
