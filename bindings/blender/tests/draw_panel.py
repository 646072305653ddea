"""Draws docs/pictures/blender_panel.png: bakes a scene by the buttons of the panel and keeps pictures of it.

    xvfb-run -s "-screen 0 1200x2450x24" blender --enable-event-simulate --factory-startup -P draw_panel.py -- \\
      SCENE.blend OUT [--collections NAMES] [--recipe NAME] [--rig-budget N] [--baked]

SCENE is a copy of a scene that may be written beside; the picture is of that of rigify_face.py with --collections 0,1,2, made
smaller by ImageMagick: convert OUT.png -crop 911x1975+80+0 +repage +dither -colors 160 blender_panel.png. OUT.before.png, OUT.running.png,
OUT.error.png and OUT.png are the 3D view with nothing baked, during the bake, with an error, and at the end."""

import argparse
import pathlib
import sys
import traceback

import bpy

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))

# Where the add-on's tab is in the sidebar, below those named Item, Tool and View: from the right and from the top, at scale 1.
TAB = 9, 170


def sidebar():
    """The window, the 3D view, and the region of its sidebar."""
    window = bpy.context.window_manager.windows[0]
    area = next(area for area in window.screen.areas if area.type == "VIEW_3D")
    return window, area, next(region for region in area.regions if region.type == "UI")


def open_tab():
    """Shows the add-on's tab, by the mouse: before Blender 4.2 no property says which tab is shown."""
    window, area, region = sidebar()
    scale = bpy.context.preferences.system.ui_scale
    x, y = region.x + region.width - int(TAB[0] * scale), region.y + region.height - int(TAB[1] * scale)
    window.event_simulate(type="MOUSEMOVE", value="NOTHING", x=x, y=y)
    yield 0.5
    for value in "PRESS", "RELEASE", "PRESS", "RELEASE":  # the first click only ends the splash screen
        window.event_simulate(type="LEFTMOUSE", value=value, x=x, y=y)
        yield 0.5
    window.event_simulate(type="MOUSEMOVE", value="NOTHING", x=area.x + area.width // 3, y=area.y + area.height // 3)
    yield 0.5


def show_only_surfaces():
    """Nothing but the scene's surfaces and the sidebar. Called before Rigify's bones are drawn, which Blender 3.4 cannot where
    OpenGL is software."""
    _, area, _ = sidebar()
    space = area.spaces.active
    space.show_region_toolbar = space.show_region_header = space.overlay.show_overlays = space.show_gizmo = False
    space.show_region_tool_header = False
    space.show_region_ui = True


def look_at(objects):
    window, area, _ = sidebar()
    region = next(region for region in area.regions if region.type == "WINDOW")
    for shown in bpy.context.view_layer.objects:
        shown.select_set(shown in objects)
    with bpy.context.temp_override(window=window, area=area, region=region):
        bpy.ops.view3d.view_axis(type="FRONT")
        bpy.ops.view3d.view_selected()
    view = area.spaces.active.region_3d  # beside the sidebar
    view.view_distance *= 1.4
    view.view_location.x += 0.09 * view.view_distance
    bpy.ops.object.select_all(action="DESELECT")


def redrawn():
    """Until panels that have grown have their new places."""
    for _ in range(3):
        sidebar()[1].tag_redraw()
        yield 1


def take_picture(path):
    window, area, region = sidebar()
    print(f"{path}: sidebar {region.width} of {area.width} x {area.height} pixels, scale {bpy.context.preferences.system.ui_scale:.2f}")
    with bpy.context.temp_override(window=window, area=area):
        bpy.ops.screen.screenshot_area(filepath=str(path))


def press(name, **options):
    """A button that may fail: the panel shows it."""
    group, name = name.split(".")
    try:
        getattr(getattr(bpy.ops, group), name)("EXEC_DEFAULT", **options)
    except RuntimeError as error:
        print(f"{name}: {error}")


def draw(options):
    """What is done, step by step; gives the seconds after which to go on."""
    import facebaker_blender
    from facebaker_blender import window_jobs

    facebaker_blender.register()
    show_only_surfaces()
    yield 1
    bpy.ops.wm.open_mainfile(filepath=str(options.scene), load_ui=False)
    yield 1
    yield from open_tab()
    chosen, out = bpy.context.scene.facebaker, str(options.out)
    chosen.collections, chosen.recipe = options.collections, options.recipe
    chosen.rig_budget, chosen.out = options.rig_budget, f"//{options.out.stem}.fbk"
    bpy.ops.object.select_all(action="DESELECT")
    press("facebaker.choose")
    press("facebaker.find")
    meshes = [item.object for item in chosen.meshes]
    look_at(meshes)
    yield 1
    take_picture(f"{out}.before.png")
    turned = next((item for item in chosen.controls if item.range_names[0].endswith("_angle")), chosen.controls[0])
    chosen.control = list(chosen.controls).index(turned)
    press("facebaker.fold", group=turned.group)
    if not options.baked:
        chosen.out = "/proc/nowhere/face.fbk"
        press("facebaker.bake")
        yield from redrawn()
        take_picture(f"{out}.error.png")
        chosen.out = f"//{options.out.stem}.fbk"
        press("facebaker.bake")
    job, pictures = window_jobs.job_of(bpy.context), 0
    while job.process.running:
        yield 2
        if job.process.progress.left and not pictures:
            take_picture(f"{out}.running.png")
            pictures += 1
    yield 1
    chosen.colours = True
    press("facebaker.show")
    from facebaker_blender.bake_settings import load_settings
    from facebaker_blender.error_display import previews_in
    from facebaker_blender.show_face import pose_from_shots

    pose_from_shots(load_settings(job.settings))
    look_at([*meshes, *previews_in(bpy.context.scene)])
    yield from redrawn()
    take_picture(options.out)


def main(words):
    parser = argparse.ArgumentParser(prog="draw_panel")
    parser.add_argument("scene", type=lambda text: pathlib.Path(text).resolve())
    parser.add_argument("out", type=lambda text: pathlib.Path(text).resolve())
    parser.add_argument("--collections", default="")
    parser.add_argument("--recipe", default="compact")
    parser.add_argument("--rig-budget", type=int, default=3000)
    parser.add_argument("--baked", action="store_true", help="show what an earlier call baked")
    steps = draw(parser.parse_args(words))

    def go_on():
        try:
            return next(steps)
        except StopIteration:
            bpy.ops.wm.quit_blender()
        except Exception:
            traceback.print_exc()
            bpy.ops.wm.quit_blender()
        return None

    bpy.app.timers.register(go_on, first_interval=1, persistent=True)


main(sys.argv[sys.argv.index("--") + 1 :])
