extends Node3D
# Poses the face of the scene, and every other one in faces/, and compares positions with those that dump_poses has written
# beside them by the C interface. Ends the process with 0 only if every check held. With a renderer (not --headless) it also reads
# back what the graphics card has.

const FaceBakerMesh4 = preload("res://addons/facebaker/face_baker_mesh.gd")

var failures := 0
var checks := 0
var signals := {}
var rendered := DisplayServer.get_name() != "headless"


func _ready() -> void:
	_check_scene()
	var compared := 0
	for file in DirAccess.get_files_at("res://faces"):
		if file.ends_with(".fbk"):
			_compare("res://faces/" + file.get_basename())
			compared += 1
	_that(compared >= 4, "there are several faces")
	_check_driven_joints()
	_check_errors()
	_check_properties()
	_check_materials()
	_check_levels()
	_check_seen()
	_check_saved_scene()
	if rendered:
		await _check_camera()
	_time()
	print("%d checks of %d faces in Godot %s%s, %d failed" % [checks, compared, Engine.get_version_info()["string"],
			", with the buffers of " + RenderingServer.get_video_adapter_name() if rendered else ", headless", failures])
	get_tree().quit(0 if failures == 0 and checks > 100 else 1)


func _that(holds: bool, what: String) -> void:
	checks += 1
	if not holds:
		failures += 1
		printerr("not so: " + what)


func _make_node() -> MeshInstance3D:
	var node := FaceBakerMesh4.new()
	add_child(node)
	return node


# The face that the scene file names is loaded, posed by its script and shown.
func _check_scene() -> void:
	var node: MeshInstance3D = $Face
	_that(node.face != null, "the scene's face is loaded")
	if node.face == null:
		return
	_that(node.mesh.get_surface_count() == node.face.surface_count(), "it has its surfaces")
	_that(node.face.mesh_count() > 1, "of several meshes")
	var before: PackedByteArray = node.face.positions().to_byte_array()
	_that(node.set_control(node.face.control_name(0), node.face.control_maximum(0)), "a control is set by its name")
	node.update_pose()
	_that(node.face.positions().to_byte_array() != before, "the pose has changed")
	node.reset_controls()
	node.update_pose()
	_that(node.face.positions().to_byte_array() == before, "it is at rest again")


func _compare(path: String) -> void:
	var file := FileAccess.open(path + ".poses", FileAccess.READ)
	var poses := file.get_32()
	var controls := file.get_32()
	var vertices := file.get_32()
	var sockets := file.get_32()
	var channels := file.get_32()
	var tangents := file.get_32()
	var joints := file.get_32()
	var node := _make_node()
	node.metres = false
	node.face_file = path + ".fbk"
	_that(node.face != null and node.face.vertex_count() == vertices, path + " is loaded")
	if node.face == null:
		return
	for p in poses:
		var values := file.get_buffer(4 * controls).to_float32_array()
		var floats := file.get_buffer(12 * vertices)
		var expected := PackedVector3Array()
		for v in vertices:
			expected.append(Vector3(floats.decode_float(12 * v), floats.decode_float(12 * v + 4), floats.decode_float(12 * v + 8)))
		file.seek(file.get_position() + 4 * 3 * vertices * (1 + tangents))
		var frames := file.get_buffer(4 * sockets).to_float32_array()
		file.seek(file.get_position() + 4 * channels)
		var joint_frames := file.get_buffer(4 * joints).to_float32_array()
		node.set_controls(values)
		node.update_pose()
		_that(node.face.positions().to_byte_array() == floats, "%s, pose %d: positions" % [path, p])
		for s in node.face.socket_count():
			_check_frame(node, node.face.socket_frame(s), frames, s, "%s, pose %d: socket" % [path, p])
			var place: Transform3D = node.socket_transform(node.face.socket_name(s))
			_check_place(place, node.face.socket_frame(s), "%s, pose %d: socket" % [path, p])
			_that(absf(place.basis.determinant() - 1.0) < 1e-3, "%s, pose %d: the socket is turned and not mirrored" % [path, p])
		_that(12 * node.face.driven_joint_count() == joints, path + " has its driven joints")
		for j in node.face.driven_joint_count():
			_check_frame(node, node.face.driven_joint_frame(j), joint_frames, j, "%s, pose %d: driven joint" % [path, p])
			var place: Transform3D = node.driven_joint_transform(node.face.driven_joint_name(j))
			_check_place(place, node.face.driven_joint_frame(j), "%s, pose %d: driven joint" % [path, p])
		_check_mesh(node, expected, "%s, pose %d: " % [path, p])
	node.metres = true
	_check_buffers(node, path + " in metres: ")
	var unit: float = {"m": 1.0, "cm": 0.01, "mm": 0.001}[node.face.units()]
	var first: Vector3 = node.face.surface_vertices(0)[0]
	var source: Vector3 = node.face.positions()[node.face.surface_sources(0)[0]]
	_that(absf(first.length() - source.length() * unit) < 1e-4 * source.length(), path + " in metres")
	node.free()


# A frame is the one at its place among those of the C interface.
func _check_frame(node: MeshInstance3D, found: PackedFloat32Array, frames: PackedFloat32Array, at: int, where: String) -> void:
	if node.face.up_axis() == "y":
		_that(found.to_byte_array() == frames.slice(12 * at, 12 * at + 12).to_byte_array(), where)


# The transform of the node is that of the frame.
func _check_place(place: Transform3D, frame: PackedFloat32Array, where: String) -> void:
	_that(place.origin == Vector3(frame[3], frame[7], frame[11]), where + ": origin")
	_that(place.basis.x == Vector3(frame[0], frame[4], frame[8]), where + ": axis")


# Which joints the controls drive, where they are at rest, and what follows them.
func _check_driven_joints() -> void:
	var node := _make_node()
	node.metres = false
	node.face_file = "res://faces/driven.fbk"
	var face: FaceBakerFace = node.face
	_that(face.driven_joint_count() == 4, "there are four driven joints")
	for j in face.driven_joint_count():
		_that(face.find_driven_joint(face.driven_joint_name(j)) == j, "a driven joint is found by its name")
		_that(face.driven_joint_parent(j) < j and face.driven_joint_parent(j) >= -1, "it comes after its parent")
		_that(face.driven_joint_rest(j) == face.driven_joint_frame(j), "it is at rest")
	_that(face.driven_joint_numbers(0) == 7 and face.driven_joint_numbers(2) == 0, "the jaw turns, and the pin does not move")
	_that(face.driven_joint_outer_rotations(0) == 0 and face.driven_joint_outer_rotations(3) == 2, "the lid turns by three")
	var influences := face.driven_influences()
	_that(influences > 0 and face.driven_skin_joints().size() == face.vertex_count() * influences, "joints of vertices")
	_that(face.driven_skin_weights().size() == face.vertex_count() * influences, "weights of vertices")
	var largest := 0.0
	for weight in face.driven_skin_weights():
		largest = maxf(largest, weight)
	_that(largest > 0.25 and largest <= 1.0, "weights are weights: %f" % largest)
	for c in face.control_count():
		node.set_control_at(c, face.control_maximum(c))
	node.update_pose()
	_that(node.driven_joint_transform("jaw") != node._transform(face.driven_joint_rest(0)), "the jaw has moved")
	_that(node.driven_joint_transform("no such joint") == Transform3D(), "a joint that is not there is an error")
	_that("jaw" in face.last_error(), "which names those there are: " + face.last_error())
	node.free()


# The mesh in the scene, which was filled in place, against one that the engine makes of the arrays of the same pose.
func _check_mesh(node: MeshInstance3D, expected: PackedVector3Array, where: String) -> void:
	var shown: ArrayMesh = node.mesh
	_check_buffers(node, where)
	node._make_mesh()
	_that(node.mesh != shown and node.mesh.get_surface_count() == shown.get_surface_count(), where + "surfaces are as before")
	var seen := {}
	for s in node.mesh.get_surface_count():
		var vertices: PackedVector3Array = node.mesh.surface_get_arrays(s)[Mesh.ARRAY_VERTEX]
		var wanted := PackedVector3Array()
		for source in node.face.surface_sources(s):
			var v: Vector3 = expected[source]
			wanted.append(Vector3(v.x, v.z, -v.y) if node.face.up_axis() == "z" else v)
			seen[source] = true
		_that(vertices.to_byte_array() == wanted.to_byte_array(), where + "the mesh in the scene has the positions")
	_that(seen.size() <= expected.size() and seen.size() > 0, where + "vertices are shown")
	var box: AABB = node.mesh.custom_aabb.grow(1e-3 + 1e-4 * node.mesh.custom_aabb.size.length())
	var within := true
	for v in node.face.surface_vertices(0):
		within = within and box.has_point(v)
	_that(within, where + "vertices are within the bounds")


# The bytes of an update are those that the engine makes of the arrays of the pose; where there is a renderer, its vertex buffer
# has them.
func _check_buffers(node: MeshInstance3D, where: String) -> void:
	for s in node.mesh.get_surface_count():
		var arrays := []
		arrays.resize(Mesh.ARRAY_MAX)
		arrays[Mesh.ARRAY_VERTEX] = node.face.surface_vertices(s)
		arrays[Mesh.ARRAY_NORMAL] = node.face.surface_normals(s)
		if node.face.surface_uvs(s).size() > 0:
			arrays[Mesh.ARRAY_TEX_UV] = node.face.surface_uvs(s)
			arrays[Mesh.ARRAY_TANGENT] = node.face.surface_tangents(s)
		var fresh := ArrayMesh.new()
		fresh.add_surface_from_arrays(Mesh.PRIMITIVE_TRIANGLES, arrays)
		var stored: PackedByteArray = RenderingServer.mesh_get_surface(fresh.get_rid(), 0)["vertex_data"]
		var tangents: bool = fresh.surface_get_format(0) & Mesh.ARRAY_FORMAT_TANGENT != 0
		var written: PackedByteArray = node.face.surface_vertex_data(s, tangents)
		_that(stored.size() > 0 and stored.size() == written.size(), where + "an update has the size of the vertex buffer")
		_that(_is_same(stored, written, node, s), where + "the bytes of an update are as the engine stores vertices")
		if rendered:
			_that(_is_same(RenderingServer.mesh_get_surface(node.mesh.get_rid(), s)["vertex_data"], written, node, s),
					where + "the renderer has the pose")


# But for tangents of what has no texture coordinates, and directions of vertices without a normal (which no triangle of the level
# has), which mean nothing.
func _is_same(one: PackedByteArray, other: PackedByteArray, node: MeshInstance3D, surface: int) -> bool:
	var normals: PackedVector3Array = node.face.surface_normals(surface)
	var count := normals.size()
	var stride := (one.size() / count) - 12
	var compared := stride if node.face.surface_uvs(surface).size() > 0 else 4
	if one.slice(0, 12 * count) != other.slice(0, 12 * count):
		return false
	for i in count:
		var at := 12 * count + stride * i
		if normals[i] != Vector3.ZERO and one.slice(at, at + compared) != other.slice(at, at + compared):
			return false
	return true


func _on_signal(which: String) -> void:
	signals[which] = signals.get(which, 0) + 1


func _on_failed(message: String) -> void:
	signals["failed"] = message


func _check_errors() -> void:
	var node := _make_node()
	node.face_failed.connect(_on_failed)
	node.face_loaded.connect(_on_signal.bind("loaded"))
	node.posed.connect(_on_signal.bind("posed"))
	node.face_file = "res://faces/broken.bin"
	_that(node.face == null and "broken.bin" in str(signals.get("failed")), "a broken archive is refused by name: " + str(signals))
	node.face_file = "res://no_such.fbk"
	_that("no_such.fbk" in str(signals.get("failed")), "so is one that is not there")
	node.face_file = "res://faces/tiny.fbk"
	_that(signals.get("loaded") == 1, "face_loaded")
	_that(not node.set_control(node.face.control_name(0) + "x", 1.0), "an unknown control is refused")
	_that(node.face.control_name(0) in node.face.last_error(), "with the closest name: " + node.face.last_error())
	node.set_control_at(0, node.face.control_maximum(0))
	node.update_pose()
	node.update_pose()
	_that(signals.get("posed") == 1, "posed once a change")
	node.set_control_at(0, NAN)
	node.update_pose()
	_that(node.face.control_name(0) in str(signals.get("failed")), "NaN is refused by the control's name")
	node.set_control_at(0, node.face.control_maximum(0) * 0.5)
	node.update_pose()
	_that(signals.get("posed") == 2, "it goes on with a number")
	node.set_control_at(99, 1.0)  # reported as an error, and nothing happens
	_that(node.face.load_bytes(PackedByteArray()) != "", "no bytes are no archive")
	_that(not node.face.is_loaded(), "nothing is loaded then")
	node.free()


func _check_properties() -> void:
	var node := FaceBakerMesh4.new()
	node.set("controls/" + "later", 0.5)  # as a scene does before the face is loaded
	add_child(node)
	node.face_file = "res://faces/tiny.fbk"
	var sliders := 0
	for property in node.get_property_list():
		if not property.name.begins_with("controls/"):
			continue
		_that(property.hint == PROPERTY_HINT_RANGE, property.name + " is a slider")
		node.set(property.name, node.face.control_maximum(sliders))
		_that(node.get(property.name) == node.face.get_control(sliders), property.name + " is set")
		sliders += 1
	_that(sliders == node.face.control_count(), "there is a slider for each control")
	node.free()


# Materials of the mesh and overrides of the node, of every surface, stay whatever is posed, scaled or loaded.
func _check_materials() -> void:
	var node := _make_node()
	node.face_file = "res://faces/character.fbk"
	var count: int = node.mesh.get_surface_count()
	_that(count > 1, "there are several surfaces")
	var overrides := []
	var materials := []
	for s in count:
		overrides.append(StandardMaterial3D.new())
		materials.append(StandardMaterial3D.new())
		node.set_surface_override_material(s, overrides[s])
		node.mesh.surface_set_material(s, materials[s])
	node.set_control_at(0, node.face.control_maximum(0))
	node.update_pose()
	_check_kept(node, overrides, materials, "after a pose")
	node.metres = false
	_check_kept(node, overrides, materials, "after another unit")
	node.face_file = "res://faces/broken.bin"
	node.face_file = "res://faces/character.fbk"
	_check_kept(node, overrides, [], "after the file was loaded anew")
	node.free()


func _check_kept(node: MeshInstance3D, overrides: Array, materials: Array, when: String) -> void:
	for s in overrides.size():
		_that(s < node.get_surface_override_material_count() and node.get_surface_override_material(s) == overrides[s],
				"surface %d has its override %s" % [s, when])
	for s in materials.size():
		_that(node.mesh.surface_get_material(s) == materials[s], "surface %d has its material %s" % [s, when])


# The triangles are those of the level that is posed; materials and overrides stay.
func _check_levels() -> void:
	var node := _make_node()
	node.face_file = "res://faces/levels.fbk"
	_that(node.face.level_count() == 3, "there are three levels")
	var material := StandardMaterial3D.new()
	var override := StandardMaterial3D.new()
	node.mesh.surface_set_material(0, material)
	node.set_surface_override_material(0, override)
	var meshes := {}
	var triangles := []
	for lod in [0.0, 1.5, 9.0, 1.0, 0.25]:
		node.level_of_detail = lod
		node.set_control_at(0, node.face.control_maximum(0) * (0.1 + 0.05 * lod))
		node.update_pose()
		var level := int(min(lod, 2.0))
		_that(node.face.level() == level, "level %d is posed" % level)
		_that(not meshes.has(level) or meshes[level] == node.mesh, "a level has one mesh")
		meshes[level] = node.mesh
		_that(node.mesh.surface_get_material(0) == material, "level %d has the material" % level)
		_that(node.get_surface_override_material(0) == override, "level %d has the override" % level)
		var arrays: Array = node.mesh.surface_get_arrays(0)
		var indices = arrays[Mesh.ARRAY_INDEX]
		_that(indices == node.face.surface_indices(0), "level %d has its triangles" % level)
		_that(arrays[Mesh.ARRAY_VERTEX].size() == node.face.surface_sources(0).size(), "level %d has their vertices" % level)
		_check_buffers(node, "level %d: " % level)
		triangles.append(indices.size())
	_that(triangles[0] > triangles[1] and triangles[1] > triangles[2], "coarser levels have fewer triangles: " + str(triangles))
	_that(triangles[3] == triangles[1] and triangles[4] == triangles[0], "and finer ones more again")
	node.free()


# Crowds stop at faces that nobody sees.
func _check_seen() -> void:
	var node := _make_node()
	node.face_file = "res://faces/tiny.fbk"
	_that(node.is_seen() or node._notifier != null, "somebody says who is seen")
	_that(node._notifier.aabb == node.mesh.custom_aabb, "by the bounds of the pose")
	node.connect("posed", _on_signal.bind("seen"))
	for unseen in [false, true]:
		node.pose_unseen = unseen
		node.set_control_at(0, node.face.control_maximum(0) * (0.75 if unseen else 0.5))
		var before: int = signals.get("seen", 0)
		node._process(0.0)
		_that(signals.get("seen", 0) == before + (1 if unseen or node.is_seen() else 0), "it is posed where it is seen")
	node.free()


# What a camera sees is posed, in every frame; what is behind it is posed where it comes into view.
func _check_camera() -> void:
	var before: MeshInstance3D = $Face
	var behind := _make_node()
	behind.face_file = "res://faces/tiny.fbk"
	var size: float = before.mesh.custom_aabb.size.length()
	var camera := Camera3D.new()
	add_child(camera)
	camera.near = 0.01 * size
	camera.position = before.mesh.custom_aabb.get_center() + Vector3(0, 0, 3 * size)
	behind.position = camera.position + Vector3(0, 0, 10 * size)
	camera.current = true
	await _frames(5)
	_that(before.is_seen() and not behind.is_seen(), "the camera sees what is before it")
	var poses := {before: 0, behind: 0}
	for node in [before, behind]:
		node.posed.connect(func() -> void: poses[node] += 1)
		node.set_control_at(0, node.face.control_maximum(0) * 0.35)
	await _frames(3)
	_that(poses[before] == 1 and poses[behind] == 0, "what nobody sees is not posed: " + str(poses.values()))
	behind.position = before.position
	await _frames(5)
	_that(behind.is_seen() and poses[behind] == 1, "what comes into view is posed: " + str(poses.values()))
	camera.free()
	behind.free()


func _frames(count: int) -> void:
	for i in count:
		await RenderingServer.frame_post_draw


# A scene that is saved and loaded has its controls and overrides.
func _check_saved_scene() -> void:
	var node := _make_node()
	node.face_file = "res://faces/character.fbk"
	for s in node.mesh.get_surface_count():
		var material := StandardMaterial3D.new()
		material.resource_name = "override %d" % s
		node.set_surface_override_material(s, material)
	node.set_control_at(1, node.face.control_maximum(1))
	node.update_pose()
	var packed := PackedScene.new()
	_that(packed.pack(node) == OK and ResourceSaver.save(packed, "user://saved.tscn") == OK, "the scene is saved")
	var loaded: MeshInstance3D = ResourceLoader.load("user://saved.tscn", "", ResourceLoader.CACHE_MODE_IGNORE).instantiate()
	add_child(loaded)
	_that(loaded.face != null and loaded.face.get_control(1) == node.face.control_maximum(1), "it has the control")
	for s in node.mesh.get_surface_count():
		var material: Material = loaded.get_surface_override_material(s)
		_that(material != null and material.resource_name == "override %d" % s, "it has the override of surface %d" % s)
	loaded.free()
	node.free()


# How long a frame takes in which a control has changed, of the largest face.
func _time() -> void:
	var node := _make_node()
	var path := "res://faces/character.fbk"
	if FileAccess.file_exists("res://faces/sample.fbk"):
		path = "res://faces/sample.fbk"
	node.face_file = path
	var control: int = node.face.control_count() / 2
	var begin := Time.get_ticks_usec()
	for i in 500:
		node.set_control_at(control, node.face.control_maximum(control) * (i % 10 + 1) * 0.1)
		node.update_pose()
	print("%.1f us a frame of %s (%d vertices)" % [(Time.get_ticks_usec() - begin) * 0.002, path, node.face.vertex_count()])
	node.free()
