extends Spatial
# Poses the face of the scene, and every other one in faces/, and compares positions with those that dump_poses has written
# beside them by the C interface. Ends the process with 0 only if every check held.

const FaceBakerMesh = preload("res://addons/facebaker/face_baker_mesh.gd")

var failures := 0
var checks := 0
var signals := {}


func _ready() -> void:
	_check_scene()
	var compared := 0
	var folder := Directory.new()
	folder.open("res://faces")
	folder.list_dir_begin(true, true)
	var name := folder.get_next()
	while name != "":
		if name.ends_with(".fbk"):
			_compare("res://faces/" + name.get_basename())
			compared += 1
		name = folder.get_next()
	_that(compared >= 4, "there are several faces")
	_check_driven_joints()
	_check_errors()
	_check_properties()
	_check_materials()
	_check_levels()
	_check_seen()
	_check_saved_scene()
	_time()
	print("%d checks of %d faces, %d failed" % [checks, compared, failures])
	get_tree().quit(0 if failures == 0 and checks > 100 else 1)


func _that(holds: bool, what: String) -> void:
	checks += 1
	if not holds:
		failures += 1
		printerr("not so: " + what)


# The face that the scene file names is loaded, posed by its script and shown.
func _check_scene() -> void:
	var node: MeshInstance = $Face
	_that(node.face != null, "the scene's face is loaded")
	_that(node.mesh.get_surface_count() == node.face.surface_count(), "it has its surfaces")
	_that(node.face.mesh_count() > 1, "of several meshes")
	var before := var2bytes(node.face.positions())
	_that(node.set_control(node.face.control_name(0), node.face.control_maximum(0)), "a control is set by its name")
	node.update_pose()
	_that(var2bytes(node.face.positions()) != before, "the pose has changed")
	node.reset_controls()
	node.update_pose()
	_that(var2bytes(node.face.positions()) == before, "it is at rest again")


func _compare(path: String) -> void:
	var file := File.new()
	file.open(path + ".poses", File.READ)
	var poses := file.get_32()
	var controls := file.get_32()
	var vertices := file.get_32()
	var sockets := file.get_32()
	var channels := file.get_32()
	var tangents := file.get_32()
	var joints := file.get_32()
	var node = FaceBakerMesh.new()
	add_child(node)
	node.metres = false
	node.face_file = path + ".fbk"
	_that(node.face != null and node.face.vertex_count() == vertices, path + " is loaded")
	for p in poses:
		var values := PoolRealArray()
		for _i in controls:
			values.append(file.get_float())
		var expected := PoolVector3Array()
		for _i in vertices:
			expected.append(Vector3(file.get_float(), file.get_float(), file.get_float()))
		file.seek(file.get_position() + 4 * 3 * vertices * (1 + tangents))
		var frames := _read_floats(file, sockets)
		file.seek(file.get_position() + 4 * channels)
		var joint_frames := _read_floats(file, joints)
		node.set_controls(values)
		node.update_pose()
		_that(var2bytes(node.face.positions()) == var2bytes(expected), "%s, pose %d: positions" % [path, p])
		for s in node.face.socket_count():
			_check_frame(node, node.face.socket_frame(s), frames, s, "%s, pose %d: socket" % [path, p])
			var place: Transform = node.socket_transform(node.face.socket_name(s))
			_check_place(place, node.face.socket_frame(s), "%s, pose %d: socket" % [path, p])
			_that(abs(place.basis.determinant() - 1.0) < 1e-3, "%s, pose %d: the socket is turned and not mirrored" % [path, p])
		_that(12 * node.face.driven_joint_count() == joints, path + " has its driven joints")
		for j in node.face.driven_joint_count():
			_check_frame(node, node.face.driven_joint_frame(j), joint_frames, j, "%s, pose %d: driven joint" % [path, p])
			var place: Transform = node.driven_joint_transform(node.face.driven_joint_name(j))
			_check_place(place, node.face.driven_joint_frame(j), "%s, pose %d: driven joint" % [path, p])
		_check_mesh(node, expected, "%s, pose %d: " % [path, p])
	node.metres = true
	var unit: float = {"m": 1.0, "cm": 0.01, "mm": 0.001}[node.face.units()]
	var first: Vector3 = node.face.surface_vertices(0)[0]
	var source: Vector3 = node.face.positions()[node.face.surface_sources(0)[0]]
	_that(abs(first.length() - source.length() * unit) < 1e-4 * source.length(), path + " in metres")
	_free(node)


func _read_floats(file: File, count: int) -> PoolRealArray:
	var floats := PoolRealArray()
	for _i in count:
		floats.append(file.get_float())
	return floats


# A frame is the one at its place among those of the C interface.
func _check_frame(node: MeshInstance, found: PoolRealArray, frames: PoolRealArray, at: int, where: String) -> void:
	var expected := PoolRealArray()
	for i in 12:
		expected.append(frames[12 * at + i])
	if node.face.up_axis() == "y":
		_that(var2bytes(found) == var2bytes(expected), where)


# The transform of the node is that of the frame.
func _check_place(place: Transform, frame: PoolRealArray, where: String) -> void:
	_that(place.origin == Vector3(frame[3], frame[7], frame[11]), where + ": origin")
	_that(place.basis.x == Vector3(frame[0], frame[4], frame[8]), where + ": axis")


# Which joints the controls drive, where they are at rest, and what follows them.
func _check_driven_joints() -> void:
	var node = FaceBakerMesh.new()
	add_child(node)
	node.metres = false
	node.face_file = "res://faces/driven.fbk"
	var face = node.face
	_that(face.driven_joint_count() == 4, "there are four driven joints")
	for j in face.driven_joint_count():
		_that(face.find_driven_joint(face.driven_joint_name(j)) == j, "a driven joint is found by its name")
		_that(face.driven_joint_parent(j) < j and face.driven_joint_parent(j) >= -1, "it comes after its parent")
		_that(var2bytes(face.driven_joint_rest(j)) == var2bytes(face.driven_joint_frame(j)), "it is at rest")
	_that(face.driven_joint_numbers(0) == 7 and face.driven_joint_numbers(2) == 0, "the jaw turns, and the pin does not move")
	_that(face.driven_joint_outer_rotations(0) == 0 and face.driven_joint_outer_rotations(3) == 2, "the lid turns by three")
	var influences: int = face.driven_influences()
	_that(influences > 0 and face.driven_skin_joints().size() == face.vertex_count() * influences, "joints of vertices")
	_that(face.driven_skin_weights().size() == face.vertex_count() * influences, "weights of vertices")
	var largest := 0.0
	for weight in face.driven_skin_weights():
		largest = max(largest, weight)
	_that(largest > 0.25 and largest <= 1.0, "weights are weights: %f" % largest)
	for c in face.control_count():
		node.set_control_at(c, face.control_maximum(c))
	node.update_pose()
	_that(node.driven_joint_transform("jaw") != node._transform(face.driven_joint_rest(0)), "the jaw has moved")
	_that(node.driven_joint_transform("no such joint") == Transform(), "a joint that is not there is an error")
	_that("jaw" in face.last_error(), "which names those there are: " + face.last_error())
	_free(node)


# What the scene's mesh has in the rendering server: as the engine lays out a mesh made of the same arrays, which the bytes of
# an update are compared with; and its vertices are the face's, all of them.
func _check_mesh(node: MeshInstance, expected: PoolVector3Array, where: String) -> void:
	var updated := []
	for s in node.mesh.get_surface_count():
		updated.append(node.face.surface_bytes(s))
	node._make_mesh()
	var seen := {}
	for s in node.mesh.get_surface_count():
		var stored: PoolByteArray = VisualServer.mesh_surface_get_array(node.mesh.get_rid(), s)
		_that(stored.size() > 0 and stored == updated[s], where + "the bytes of an update are as the engine stores vertices")
		var shown: PoolVector3Array = node.mesh.surface_get_arrays(s)[Mesh.ARRAY_VERTEX]
		var sources: PoolIntArray = node.face.surface_sources(s)
		var wanted := PoolVector3Array()
		for source in sources:
			var v: Vector3 = expected[source]
			wanted.append(Vector3(v.x, v.z, -v.y) if node.face.up_axis() == "z" else v)
			seen[source] = true
		_that(var2bytes(shown) == var2bytes(wanted), where + "the mesh in the scene has the positions")
	if node.mesh.get_surface_count() > 0:
		_that(seen.size() <= expected.size() and seen.size() > 0, where + "vertices are shown")
	var box: AABB = node.mesh.custom_aabb.grow(1e-3 + 1e-4 * node.mesh.custom_aabb.size.length())
	for v in node.face.surface_vertices(0):
		if not box.has_point(v):
			_that(false, where + "vertices are within the bounds")
			break


func _on_signal(name: String) -> void:
	signals[name] = signals.get(name, 0) + 1


func _on_failed(message: String) -> void:
	signals["failed"] = message


func _check_errors() -> void:
	var node = FaceBakerMesh.new()
	add_child(node)
	node.connect("face_failed", self, "_on_failed")
	node.connect("face_loaded", self, "_on_signal", ["loaded"])
	node.connect("posed", self, "_on_signal", ["posed"])
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
	_that(node.face.load_bytes(PoolByteArray()) != "", "no bytes are no archive")
	_that(not node.face.is_loaded(), "nothing is loaded then")
	_free(node)


func _check_properties() -> void:
	var node = FaceBakerMesh.new()
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
	_free(node)


# Materials of the mesh and overrides of the node, of every surface, stay whatever is posed, scaled or loaded.
func _check_materials() -> void:
	var node = FaceBakerMesh.new()
	add_child(node)
	node.face_file = "res://faces/character.fbk"
	var count: int = node.mesh.get_surface_count()
	_that(count > 1, "there are several surfaces")
	var overrides := []
	var materials := []
	for s in count:
		overrides.append(SpatialMaterial.new())
		materials.append(SpatialMaterial.new())
		node.set_surface_material(s, overrides[s])
		node.mesh.surface_set_material(s, materials[s])
	node.set_control_at(0, node.face.control_maximum(0))
	node.update_pose()
	_check_kept(node, overrides, materials, "after a pose")
	node.metres = false
	_check_kept(node, overrides, materials, "after another unit")
	node.face_file = "res://faces/broken.bin"
	node.face_file = "res://faces/character.fbk"
	_check_kept(node, overrides, [], "after the file was loaded anew")
	_free(node)


func _check_kept(node: MeshInstance, overrides: Array, materials: Array, when: String) -> void:
	for s in overrides.size():
		_that(s < node.get_surface_material_count() and node.get_surface_material(s) == overrides[s],
				"surface %d has its override %s" % [s, when])
	for s in materials.size():
		_that(node.mesh.surface_get_material(s) == materials[s], "surface %d has its material %s" % [s, when])


# The triangles are those of the level that is posed; materials and overrides stay.
func _check_levels() -> void:
	var node = FaceBakerMesh.new()
	add_child(node)
	node.face_file = "res://faces/levels.fbk"
	_that(node.face.level_count() == 3, "there are three levels")
	var material := SpatialMaterial.new()
	var override := SpatialMaterial.new()
	node.mesh.surface_set_material(0, material)
	node.set_surface_material(0, override)
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
		_that(node.get_surface_material(0) == override, "level %d has the override" % level)
		var arrays: Array = node.mesh.surface_get_arrays(0)
		var indices = arrays[Mesh.ARRAY_INDEX]
		_that(indices == node.face.surface_indices(0), "level %d has its triangles" % level)
		_that(arrays[Mesh.ARRAY_VERTEX].size() == node.face.surface_sources(0).size(), "level %d has their vertices" % level)
		triangles.append(indices.size())
	_that(triangles[0] > triangles[1] and triangles[1] > triangles[2], "coarser levels have fewer triangles: " + str(triangles))
	_that(triangles[3] == triangles[1] and triangles[4] == triangles[0], "and finer ones more again")
	_free(node)


# Crowds stop at faces that nobody sees.
func _check_seen() -> void:
	var node = FaceBakerMesh.new()
	add_child(node)
	node.face_file = "res://faces/tiny.fbk"
	_that(node.is_seen() or node._notifier != null, "somebody says who is seen")
	_that(node._notifier.aabb == node.mesh.custom_aabb, "by the bounds of the pose")
	node.connect("posed", self, "_on_signal", ["seen"])
	for unseen in [false, true]:
		node.pose_unseen = unseen
		node.set_control_at(0, node.face.control_maximum(0) * (0.75 if unseen else 0.5))
		var before: int = signals.get("seen", 0)
		node._process(0.0)
		_that(signals.get("seen", 0) == before + (1 if unseen or node.is_seen() else 0), "it is posed where it is seen")
	_free(node)


# A scene that is saved and loaded has its controls and overrides.
func _check_saved_scene() -> void:
	var node = FaceBakerMesh.new()
	add_child(node)
	node.face_file = "res://faces/character.fbk"
	for s in node.mesh.get_surface_count():
		var material := SpatialMaterial.new()
		material.resource_name = "override %d" % s
		node.set_surface_material(s, material)
	node.set_control_at(1, node.face.control_maximum(1))
	node.update_pose()
	var packed := PackedScene.new()
	_that(packed.pack(node) == OK and ResourceSaver.save("user://saved.tscn", packed) == OK, "the scene is saved")
	var loaded: MeshInstance = ResourceLoader.load("user://saved.tscn", "", true).instance()
	add_child(loaded)
	_that(loaded.face != null and loaded.face.get_control(1) == node.face.control_maximum(1), "it has the control")
	for s in node.mesh.get_surface_count():
		var material: Material = loaded.get_surface_material(s)
		_that(material != null and material.resource_name == "override %d" % s, "it has the override of surface %d" % s)
	_free(loaded)
	_free(node)


# How long a frame takes in which a control has changed, of the largest face.
func _time() -> void:
	var node = FaceBakerMesh.new()
	add_child(node)
	var path := "res://faces/character.fbk"
	if File.new().file_exists("res://faces/sample.fbk"):
		path = "res://faces/sample.fbk"
	node.face_file = path
	var control := int(node.face.control_count() / 2)
	var begin := OS.get_ticks_usec()
	for i in 500:
		node.set_control_at(control, node.face.control_maximum(control) * (i % 10 + 1) * 0.1)
		node.update_pose()
	print("%.1f us a frame of %s (%d vertices), headless" % [(OS.get_ticks_usec() - begin) * 0.002, path, node.face.vertex_count()])
	_free(node)


# The headless server does not tell nodes that their mesh is gone.
func _free(node: MeshInstance) -> void:
	node.mesh = null
	node.free()
