"""Runs against a real raxel: $RAXEL is the program, the current folder the repository."""

import asyncio
import inspect
import os
import pathlib
import shutil
import sys
import tempfile
import unittest

import raxel

SCENE = dict(file="graphs/inspect.toml", world="worlds/menger.toml", size=(32, 18))


# Says much on stderr before it is ready, and answers whatever it is asked.
CHATTY = """import json, sys
sys.stderr.write("x" * 500_000)
print(json.dumps({"event": "ready", "protocol": 1}), flush=True)
for line in sys.stdin:
    print(json.dumps({"id": json.loads(line)["id"], "ok": True}), flush=True)
    break
sys.stderr.write("the end")
sys.exit(7)
"""


class Starting(unittest.TestCase):
    def test_a_program_that_is_not_there_is_named(self):
        with self.assertRaisesRegex(FileNotFoundError, "`/no/such/raxel` cannot be started.*RAXEL"):
            raxel.open(binary="/no/such/raxel")

    def test_much_on_stderr_stops_nothing_and_its_end_is_told(self):
        session = raxel.Session([sys.executable, "-c", CHATTY])
        session.pause()
        with self.assertRaisesRegex(raxel.Disconnected, "exit code 7: x+the end"):
            session.info()
        session.close()


# `sum` is shown and counts frames; `hidden` is 7 in each of them.
GRAPH = """name = "sum"
present = "sum"
[targets.sum]
format = "r32f"
size = [1, 1]
[targets.hidden]
format = "r32f"
size = [1, 1]
[[passes]]
name = "sum"
shader = "add.comp"
dispatch = [1, 1, 1]
bind = { to = "sum" }
push = { value = 1.0 }
[[passes]]
name = "hidden"
shader = "set.comp"
dispatch = [1, 1, 1]
bind = { to = "hidden" }
push = { value = 7.0 }
"""
SHADER = """#version 460
layout(local_size_x = 1) in;
layout(r32f) %s uniform image2D to;
layout(push_constant) uniform Push { float value; };
void main() { imageStore(to, ivec2(0), vec4(value) %s); }
"""


class Reading(unittest.TestCase):
    def test_a_read_runs_no_frame(self):
        with tempfile.TemporaryDirectory() as folder:
            for path, text in {
                "raxel.toml": "",
                "graphs/sum.toml": GRAPH,
                "shaders/add.comp": SHADER % ("", "+ imageLoad(to, ivec2(0))"),
                "shaders/set.comp": SHADER % ("writeonly", ""),
            }.items():
                os.makedirs(os.path.dirname(os.path.join(folder, path)), exist_ok=True)
                with open(os.path.join(folder, path), "w") as file:
                    file.write(text)
            with raxel.open(file=os.path.join(folder, "graphs/sum.toml"), size=(4, 4)) as session:
                for frame in (1.0, 2.0, 3.0):
                    session.step()
                    read = [session.pixel(name, 0, 0)[0] for name in ("sum", "hidden", "sum")]
                    self.assertEqual(read, [frame, 7.0, frame])


class Driving(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.session = raxel.open(**SCENE)

    @classmethod
    def tearDownClass(cls):
        cls.session.close()

    def test_info_has_everything_by_name(self):
        info = self.session.info()
        self.assertEqual((info["graph"], info["size"]), ("graphs/inspect.toml", [32, 18]))
        self.assertIn("depth", info["targets"])
        self.assertIn("sky_depth", [param["name"] for param in info["params"]])

    def test_a_param_changes_what_is_read(self):
        self.assertEqual(self.session.set("sky_depth", 777.0), 777.0)
        self.session.step()
        depth = self.session.texels("depth")
        self.assertEqual(tuple(depth.shape), (18, 32, 1))
        values = [value for row in depth.tolist() for (value,) in row]
        self.assertIn(777.0, values)
        self.assertTrue(any(0.0 < value < 777.0 for value in values))
        # One texel is the same number.
        self.assertEqual(self.session.pixel("depth", 31, 17), [depth[17, 31, 0]])
        # So are the statistics, and a search finds where the largest stands.
        numbers = self.session.statistics("depth")["channels"][0]
        self.assertEqual((numbers["largest"], numbers["count"]), (max(values), 32 * 18))
        place = self.session.find("depth", "largest")
        self.assertEqual(depth[place["y"], place["x"], 0], numbers["largest"])
        later = self.session.find("depth", "largest", start=place)
        self.assertEqual(depth[later["y"], later["x"], 0], numbers["largest"])
        self.assertIsNone(self.session.find("depth", "nan"))

    def test_refusals_change_nothing(self):
        before = self.session.camera()
        for wrong in (
            lambda: self.session.set("sky_dpeth", 1.0),
            lambda: self.session.set("sky_depth", "much"),
            lambda: self.session.texels("dept"),
            lambda: self.session.pixel("depth", 32, 0),
            lambda: self.session.camera("nowhere"),
            lambda: self.session.step(0),
            lambda: self.session.ask("fly"),
            lambda: self.session.screenshot("no/such/folder.png"),
        ):
            with self.assertRaises(raxel.Refused):
                wrong()
        self.assertEqual(self.session.camera(), before)
        with self.assertRaisesRegex(raxel.Refused, "did you mean `sky_depth`"):
            self.session.set("sky_dpeth", 1.0)

    def test_numbers_that_json_lacks_are_refused_and_those_of_numpy_are_not(self):
        for value in (float("nan"), float("inf"), [1.0, float("-inf")]):
            with self.assertRaisesRegex(ValueError, "`set` takes no NaN and no infinity"):
                self.session.set("sky_depth", value)
        if raxel.requests.numpy is None:
            return
        array, whole = raxel.requests.numpy.array, raxel.requests.numpy.int64
        frame = self.session.step(whole(2))["frame"]
        self.assertEqual(self.session.step()["frame"], frame + 1)
        sphere = {"op": "sphere", "center": array([0, 0, 0]), "radius": array(8.5), "mode": "subtract"}
        self.assertEqual(self.session.edit([sphere])["steps"], {"undo": 1, "redo": 0})
        self.session.undo()

    def test_the_camera_moves_and_time_passes(self):
        self.session.reset()
        self.assertEqual(self.session.step(3), {"frame": 2, "seconds": 2 / 60})
        self.session.pause()
        self.assertEqual(self.session.step(4), {"frame": 6, "seconds": 2 / 60})
        self.session.pause(False)
        self.assertEqual(self.session.step(), {"frame": 7, "seconds": 3 / 60})
        one = self.session.picture().tolist()
        moved = self.session.camera(position=[40.0, 20.0, 60.0], look_at=[0.0, 0.0, 0.0])
        self.assertEqual(moved["position"], [40.0, 20.0, 60.0])
        self.session.step()
        self.assertNotEqual(self.session.picture().tolist(), one)

    def test_every_pass_has_a_time_or_none(self):
        self.session.step()
        self.assertEqual(list(self.session.timings()), self.session.info()["passes"])

    def test_edits_are_undone(self):
        self.assertFalse(self.session.undo())
        edit = self.session.edit([{"op": "sphere", "center": [0, 0, 0], "radius": 8.5, "mode": "subtract"}])
        self.assertEqual(edit["steps"], {"undo": 1, "redo": 0})
        self.assertEqual([self.session.undo(), self.session.redo(), self.session.undo()], [True, True, True])

    def test_a_picture_is_a_file(self):
        self.session.step()
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "a.png")
            self.assertEqual(self.session.screenshot(path)["size"], [32, 18])
            with open(path, "rb") as file:
                self.assertEqual(file.read(8), b"\x89PNG\r\n\x1a\n")


class Arrays(unittest.TestCase):
    """Arrays come in files, and as text where files do not."""

    @staticmethod
    def all_of(session):
        session.step()
        arrays = [session.texels("depth"), session.texels("hit"), session.picture(), session.buffer("world", 64, dtype="u4")]
        return [array.tolist() for array in arrays] + [session.buffer("world", 64)]

    def test_files_and_text_have_the_same_numbers(self):
        with raxel.open(**SCENE) as session:
            before = len(session.events)
            in_files = self.all_of(session)
            folder = session._files._folder.name
            self.assertEqual(os.listdir(folder), [])
            session._files.close()
            session._files._places = []
            self.assertEqual(self.all_of(session), in_files)
            self.assertIsInstance(in_files[-1], bytes)
            self.assertEqual(len(session.events), before)

    def test_an_array_outlives_its_file_and_its_session(self):
        with raxel.open(**SCENE) as session:
            session.step()
            depth = session.texels("depth")
            folder = session._files._folder.name
            again = session.texels("depth")
        self.assertFalse(os.path.exists(folder))
        # A change of one is none of the other.
        depth[0, 0, 0] = 123.0
        self.assertNotEqual(again[0, 0, 0], 123.0)

    def test_a_folder_that_raxel_does_not_see_is_left(self):
        with raxel.open(**SCENE) as session:
            session.step()
            session._files.path()
            shutil.rmtree(session._files._folder.name)
            places = len(session._files._places)
            self.assertEqual(tuple(session.picture().shape), (18, 32, 4))
            self.assertEqual(len(session._files._places), places - 1)
            # A refusal that is about something else is one.
            with self.assertRaisesRegex(raxel.Refused, "did you mean `depth`"):
                session.texels("dept")
            self.assertEqual(len(session._files._places), places - 1)


class Panels(unittest.TestCase):
    """What the panels of a window do."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.project = folder.name
        for name in ("graphs", "shaders", "worlds"):
            shutil.copytree(name, os.path.join(self.project, name))
        self.session = raxel.open(**SCENE, cwd=self.project)
        self.addCleanup(self.session.close)

    def text(self, path):
        return pathlib.Path(self.project, path).read_text()

    def test_values_are_kept_and_written(self):
        session = self.session
        session.set("sky_depth", 50.0)
        session.save_preset("far")
        self.assertEqual(session.presets(), {"far": {"sky_depth": [50.0]}})
        session.set("sky_depth", 1.0)
        self.assertEqual(session.apply_preset("far")["changed"], ["sky_depth"])
        session.delete_preset("far")
        before = self.text("graphs/inspect.toml")
        written = session.write_params(["sky_depth"], to="declared")
        self.assertTrue(session.wait_reload(60, after=written["generation"])["reloaded"])
        self.assertIn("default = 50.0", self.text("graphs/inspect.toml"))
        self.assertEqual(session.undo_write(), ["graphs/inspect.toml"])
        self.assertEqual(self.text("graphs/inspect.toml"), before)
        self.assertEqual(session.write_camera("here")["path"], "worlds/menger.toml")
        self.assertIn("[cameras.here]", self.text("worlds/menger.toml"))

    def test_a_demo_is_opened_and_its_keys_change(self):
        session = self.session
        with self.assertRaisesRegex(raxel.Refused, "no demo runs"):
            session.keys()
        demo = "worlds/sponge.demo.toml"
        self.assertIn({"kind": "demo", "path": demo, "runs": False}, session.files())
        self.assertTrue(session.open(demo)["opened"])
        session.loop()
        for change in (lambda: session.move_key("camera", 1, 0.5), lambda: session.delete_key("camera", 1), lambda: session.write_key(seconds=0.25)):
            self.assertTrue(session.wait_reload(60, after=change()["generation"])["reloaded"])
        self.assertEqual(session.keys()["tracks"][0], {"track": "camera", "keys": [0.0, 0.25, 1.0], "movable": True})
        session.hand_back()
        session.record_params()
        session.set("sky_depth", 50.0)
        session.step(6)
        session.set("sky_depth", 60.0)
        recorded = session.record_params(on=False)
        self.assertEqual((recorded["path"], recorded["tracks"][0]["track"]), (demo, "tracks.sky_depth"))
        self.assertTrue(session.wait_reload(60, after=recorded["generation"])["reloaded"])
        self.assertIn("tracks.sky_depth", [track["track"] for track in session.keys()["tracks"]])

    def test_what_is_shown_is_mapped_and_measured(self):
        session = self.session
        session.step()
        self.assertEqual(session.display("normal", range=[0.0, 2.0])["range"], [0.0, 2.0])
        session.display()
        self.assertEqual(session.keep(), "normal, 32 × 18")
        session.camera(yaw=10.0)
        session.step()
        measured = session.measure()
        self.assertGreater(measured["flip"], 0.0)
        self.assertGreater(measured["differing"], 0)
        session.forget()
        for windows in (session.compare, session.cancel, session.fps_cap, session.fly_speed, session.brush):
            with self.assertRaisesRegex(raxel.Refused, "needs a window"):
                windows()
        self.assertEqual(session.scale(0.5)["size"], [16, 9])


class Editing(unittest.TestCase):
    def test_an_edit_is_waited_for_and_a_mistake_is_told(self):
        with tempfile.TemporaryDirectory() as project:
            for folder in ("graphs", "shaders", "worlds"):
                shutil.copytree(folder, os.path.join(project, folder))
            shader = os.path.join(project, "shaders", "inspect.comp")
            with open(shader) as file:
                text = file.read()
            with raxel.open(**SCENE, cwd=project) as session:
                session.step()
                with open(shader, "w") as file:
                    file.write(text.replace("void main", "void mian"))
                edit = session.wait_reload(60)
                self.assertFalse(edit["reloaded"])
                self.assertIn("shaders/inspect.comp", str(edit["diagnostics"]))
                session.step()
                with open(shader, "w") as file:
                    file.write(text + "\n// mended\n")
                self.assertTrue(session.wait_reload(60)["reloaded"])
                self.assertEqual(session.diagnostics()["diagnostics"], [])
                told = [event["event"] for event in session.events if event["event"] not in ("compiling", "working")]
                self.assertEqual(told, ["reload-failed", "reloaded"])

    def test_a_closed_session_says_so(self):
        with raxel.open(**SCENE) as session:
            session.step()
        for _ in range(2):
            with self.assertRaisesRegex(raxel.Disconnected, "the session is closed"):
                session.step()
            session.close()

    def test_a_project_that_does_not_open_is_said(self):
        with self.assertRaisesRegex(raxel.Disconnected, "exit code 3"):
            raxel.open("graphs/no_such_graph.toml")


class Together(unittest.IsolatedAsyncioTestCase):
    async def test_sessions_run_side_by_side(self):
        async def depth(sky):
            async with raxel.open_async(**SCENE) as session:
                self.assertEqual(await session.set("sky_depth", sky), sky)
                await session.step()
                self.assertEqual(len(await session.buffer("world", 64)), 64)
                return (await session.texels("depth")).tolist()

        for sky, rows in zip((111.0, 222.0), await asyncio.gather(depth(111.0), depth(222.0))):
            self.assertEqual(rows[0][0], [sky])

    async def test_tasks_share_a_session_and_one_may_be_cancelled(self):
        async with raxel.open_async(**SCENE) as session:
            waits = asyncio.ensure_future(session.wait_reload(0.5))
            await asyncio.sleep(0)
            asks = [asyncio.ensure_future(session.camera(position=[float(n), 0.0, 0.0])) for n in range(8)]
            await asyncio.sleep(0)
            waits.cancel()
            asks[5].cancel()
            told = await asyncio.gather(waits, *asks, return_exceptions=True)
            self.assertIsInstance(told[0], asyncio.CancelledError)
            self.assertIsInstance(told[6], asyncio.CancelledError)
            self.assertEqual([told[1 + n]["position"][0] for n in range(8) if n != 5], [n for n in range(8) if n != 5])
            with self.assertRaisesRegex(raxel.Refused, "did you mean `sky_depth`"):
                await session.set("sky_dpeth", 1.0)

    async def test_it_ends_as_a_session_does(self):
        with self.assertRaisesRegex(FileNotFoundError, "`/no/such/raxel` cannot be started.*RAXEL"):
            await raxel.open_async(binary="/no/such/raxel").start()
        with self.assertRaisesRegex(raxel.Disconnected, "exit code 3"):
            await raxel.open_async("graphs/no_such_graph.toml").start()
        session = raxel.AsyncSession([sys.executable, "-c", CHATTY])
        with self.assertRaisesRegex(raxel.Disconnected, "has not started"):
            await session.pause()
        await session.start()
        await session.pause()
        with self.assertRaisesRegex(raxel.Disconnected, "exit code 7: x+the end"):
            await session.info()
        for _ in range(2):
            await session.close()
            with self.assertRaisesRegex(raxel.Disconnected, "the session is closed"):
                await session.info()


class Types(unittest.TestCase):
    def test_every_public_function_has_types(self):
        # A release runs these tests from its wheel, so the wheel has the mark, too.
        self.assertTrue(pathlib.Path(raxel.__file__).with_name("py.typed").is_file())
        public = [getattr(raxel, name) for name in raxel.__all__]
        functions = [found for found in public if inspect.isfunction(found)]
        for kind in filter(inspect.isclass, public):
            members = inspect.getmembers(kind, inspect.isfunction)
            functions += [found for name, found in members if found.__module__.startswith("raxel") and (name == "__init__" or name[0] != "_")]
        self.assertGreater(len(functions), 60)
        for function in functions:
            signature = inspect.signature(function)
            types = [parameter.annotation for name, parameter in signature.parameters.items() if name != "self"]
            self.assertNotIn(inspect.Signature.empty, [signature.return_annotation, *types], function.__qualname__)

    def test_both_sessions_have_every_request(self):
        public = [{name for name in dir(kind) if name[0] != "_"} for kind in (raxel.Session, raxel.AsyncSession)]
        self.assertEqual(public[0] | {"start"}, public[1])
        asyncs = {name for name, found in inspect.getmembers(raxel.AsyncSession, inspect.iscoroutinefunction) if name[0] != "_"}
        self.assertEqual(public[1] - asyncs, {"prints"})
        self.assertFalse(any(inspect.iscoroutinefunction(found) for name, found in inspect.getmembers(raxel.Session) if name[0] != "_"))


if __name__ == "__main__":
    unittest.main()
