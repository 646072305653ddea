@tool
class_name FaceBakerMesh
extends MeshInstance3D
# A baked face (.fbk) in a scene of Godot 4.2 or later. Shows all meshes of the character as surfaces of one ArrayMesh, and
# fills it in place whenever a control has changed. In the inspector the controls are sliders, "controls/GROUP/NAME".

# The face was loaded; its controls can be set.
signal face_loaded
# The face could not be loaded, or a pose failed; the message says why.
signal face_failed(message)
# The mesh shows a new pose.
signal posed

# The archive. An exported game needs "*.fbk" among the files to export.
@export_file("*.fbk") var face_file := "": set = set_face_file
# Lengths in metres; else in the archive's own unit.
@export var metres := true: set = set_metres
# Level of detail: 0 is the whole, 1 the next coarser level, fractions lie between two. The triangles of the level that it is
# rounded down to are drawn.
@export_range(0, 8) var level_of_detail := 0.0: set = set_level_of_detail
# Whether it is posed while no camera sees it, too: for sockets and joints that are asked for all the same.
@export var pose_unseen := false

var face: FaceBakerFace = null  # the FaceBakerFace; null while there is none
var _stored := {}  # values of controls that a scene sets before the face is loaded
var _paths := []  # the property of each control
var _indices := {}  # the control of each property
var _reported := ""  # what is wrong with the values that are set
var _made: ArrayMesh = null  # what is shown, and filled
var _level := 0  # of its triangles
var _of_levels := {}  # the mesh of each level of detail that was shown
var _notifier := VisibleOnScreenNotifier3D.new()
var _overrides := []  # of materials by surface, for the next mesh


func set_face_file(path: String) -> void:
	face_file = path
	_open()


func set_metres(value: bool) -> void:
	metres = value
	if face:
		face.set_metres(metres)
		if _made:
			_show()


func set_level_of_detail(value: float) -> void:
	level_of_detail = maxf(0.0, value)
	if face:
		face.set_lod(level_of_detail)


# Sets a control by its name, its ARKit name or its FACS name. False, and an error, if there is none.
func set_control(control: String, value: float) -> bool:
	var index := find_control(control)
	if index < 0:
		return false
	face.set_control(index, value)
	return true


# The value of a control; its name as for set_control. 0, and an error, if there is none.
func get_control(control: String) -> float:
	var index := find_control(control)
	return face.get_control(index) if index >= 0 else 0.0


# The index of a control, for set_control_at; -1, and an error with the closest name, if there is none.
func find_control(control: String) -> int:
	if not face:
		push_error("FaceBakerMesh: no face is loaded")
		return -1
	var index: int = face.find_control(control)
	if index < 0:
		push_error("FaceBakerMesh: " + face.last_error())
	return index


# Sets a control by its index: the quickest way.
func set_control_at(index: int, value: float) -> void:
	face.set_control(index, value)


# All values, in the order of the controls.
func set_controls(values: PackedFloat32Array) -> void:
	face.set_controls(values)


# Where a socket of the last pose is, in this node: for what hangs on the face. At the origin, and an error, if there is none.
func socket_transform(socket: String) -> Transform3D:
	var index: int = face.find_socket(socket) if face else -1
	return _transform(face.socket_frame(index)) if index >= 0 else _no_transform()


# Where a joint that the controls drive is in the last pose, in this node: for what hangs on a jaw or an eye, and for bones. At
# the origin, and an error, if there is none.
func driven_joint_transform(joint: String) -> Transform3D:
	var index: int = face.find_driven_joint(joint) if face else -1
	return _transform(face.driven_joint_frame(index)) if index >= 0 else _no_transform()


func _transform(f: PackedFloat32Array) -> Transform3D:
	return Transform3D(Vector3(f[0], f[4], f[8]), Vector3(f[1], f[5], f[9]), Vector3(f[2], f[6], f[10]), Vector3(f[3], f[7], f[11]))


func _no_transform() -> Transform3D:
	push_error("FaceBakerMesh: " + (face.last_error() if face else "no face is loaded"))
	return Transform3D()


# Puts all controls at rest.
func reset_controls() -> void:
	for i in face.control_count():
		face.set_control(i, face.control_rest(i))


# Shows what was set. Called in every frame; call it to have the mesh at once.
func update_pose() -> void:
	if not face or not _made:
		return
	var result: int = face.pose()
	if result < 0:
		if face.last_error() != _reported:  # once, not in every frame
			_reported = face.last_error()
			_fail(_reported)
		return
	_reported = ""
	if result == 0:
		return
	_show()
	posed.emit()


# Whether a camera sees it. Without a picture nobody says so.
func is_seen() -> bool:
	return DisplayServer.get_name() == "headless" or _notifier.is_on_screen()


func _init() -> void:
	set_process(true)
	add_child(_notifier, false, Node.INTERNAL_MODE_FRONT)
	_notifier.screen_entered.connect(update_pose)


func _process(_delta: float) -> void:
	if pose_unseen or is_seen():
		update_pose()


func _open() -> void:
	_keep_overrides()
	face = null
	_made = null
	_of_levels = {}
	mesh = null
	_paths = []
	_indices = {}
	if face_file == "":
		notify_property_list_changed()
		return
	if not FileAccess.file_exists(face_file):
		_fail("cannot read " + face_file)
		return
	var opened := FaceBakerFace.new()
	var message := opened.load_bytes(FileAccess.get_file_as_bytes(face_file))
	if message != "":
		_fail(face_file + ": " + message)
		return
	face = opened
	face.set_metres(metres)
	face.set_lod(level_of_detail)
	for i in face.control_count():
		var group: String = face.control_group(i)
		_paths.append("controls/" + (group + "/" if group != "" else "") + face.control_name(i))
		_indices[_paths[i]] = i
		if _stored.has(_paths[i]):
			face.set_control(i, _stored[_paths[i]])
	_make_mesh()
	notify_property_list_changed()
	face_loaded.emit()


func _fail(message: String) -> void:
	push_error("FaceBakerMesh: " + message)
	face_failed.emit(message)


func _bounds() -> AABB:
	var corners: PackedVector3Array = face.bounds()
	return AABB(corners[0], corners[1] - corners[0])


# Meshes anew, of the current pose.
func _make_mesh() -> void:
	if face.pose() < 0:
		_fail(face.last_error())
		return
	_of_levels = {}
	_show_level()


# Shows the last pose.
func _show() -> void:
	if face.level() == _level:
		_fill_mesh()
	else:
		_show_level()


# Shows the last pose by the mesh of its level. Materials and overrides of the mesh that was shown stay.
func _show_level() -> void:
	_level = face.level()
	var made: ArrayMesh = _of_levels.get(_level)
	var known := made != null
	if not known:
		made = _mesh_of_pose()
		if made == null:
			return
		_of_levels[_level] = made
	for s in made.get_surface_count():
		made.surface_set_material(s, _made.surface_get_material(s) if _made else _material(face.surface_material(s)))
	_keep_overrides()
	_made = made
	mesh = made
	for s in mini(_overrides.size(), made.get_surface_count()):
		set_surface_override_material(s, _overrides[s])
	if known:
		_fill_mesh()
	else:
		_set_bounds()


# A mesh of the last pose; the only place that makes surfaces.
func _mesh_of_pose() -> ArrayMesh:
	var made := ArrayMesh.new()
	for s in face.surface_count():
		var arrays := []
		arrays.resize(Mesh.ARRAY_MAX)
		arrays[Mesh.ARRAY_VERTEX] = face.surface_vertices(s)
		arrays[Mesh.ARRAY_NORMAL] = face.surface_normals(s)
		var uvs: PackedVector2Array = face.surface_uvs(s)
		if uvs.size() > 0:
			arrays[Mesh.ARRAY_TEX_UV] = uvs
			arrays[Mesh.ARRAY_TANGENT] = face.surface_tangents(s)
		arrays[Mesh.ARRAY_INDEX] = face.surface_indices(s)
		made.add_surface_from_arrays(Mesh.PRIMITIVE_TRIANGLES, arrays, [], {}, Mesh.ARRAY_FLAG_USE_DYNAMIC_UPDATE)
		if not _layout_is_known(made, s):
			face = null
			_fail("this version of Godot lays out vertices in another way; take a later FaceBaker")
			return null
	return made


# Whether vertices lie as surface_vertex_data() has them: positions first, then normals and tangents.
func _layout_is_known(made: ArrayMesh, surface: int) -> bool:
	var count := made.surface_get_array_len(surface)
	var format := made.surface_get_format(surface)
	var normals := RenderingServer.mesh_surface_get_format_offset(format, count, Mesh.ARRAY_NORMAL)
	var tangents := RenderingServer.mesh_surface_get_format_offset(format, count, Mesh.ARRAY_TANGENT)
	return (RenderingServer.mesh_surface_get_format_vertex_stride(format, count) == 12 and normals == 12 * count
			and (not _has_tangents(made, surface) or tangents == normals + 4))


# Godot makes tangents of its own where there are none.
func _has_tangents(made: ArrayMesh, surface: int) -> bool:
	return made.surface_get_format(surface) & Mesh.ARRAY_FORMAT_TANGENT != 0


# Writes the last pose over the vertices. Surfaces, their materials and overrides stay.
func _fill_mesh() -> void:
	for s in _made.get_surface_count():
		var bytes: PackedByteArray = face.surface_vertex_data(s, _has_tangents(_made, s))
		RenderingServer.mesh_surface_update_vertex_region(_made.get_rid(), s, 0, bytes)
	_set_bounds()


func _set_bounds() -> void:
	_made.custom_aabb = _bounds()
	_notifier.aabb = _made.custom_aabb


# Overrides are lost when the mesh goes.
func _keep_overrides() -> void:
	if get_surface_override_material_count() == 0:
		return
	_overrides = []
	for s in get_surface_override_material_count():
		_overrides.append(get_surface_override_material(s))


func _material(index: int) -> StandardMaterial3D:
	var material := StandardMaterial3D.new()
	if index >= 0:
		var colour: PackedFloat32Array = face.material_colour(index)
		material.resource_name = face.material_name(index)
		material.albedo_color = Color(colour[0], colour[1], colour[2], colour[3])
	return material


func _get_property_list() -> Array[Dictionary]:
	var list: Array[Dictionary] = []
	for i in _paths.size():
		list.append({
			"name": _paths[i],
			"type": TYPE_FLOAT,
			"hint": PROPERTY_HINT_RANGE,
			"hint_string": "%f,%f,0.001" % [face.control_minimum(i), face.control_maximum(i)],
			"usage": PROPERTY_USAGE_DEFAULT,
		})
	return list


func _get(property: StringName) -> Variant:
	if _indices.has(property):
		return face.get_control(_indices[property])
	return null


func _set(property: StringName, value: Variant) -> bool:
	if not property.begins_with("controls/"):
		return false
	_stored[property] = value
	if _indices.has(property):
		face.set_control(_indices[property], value)
	return true
