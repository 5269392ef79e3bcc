// Bodies that are posed from records: linear blend skinning from frame rows of the bundle.

#import bevy_pbr::{mesh_functions, view_transformations::position_world_to_clip}
#ifdef PREPASS_PIPELINE
#import bevy_pbr::prepass_io::VertexOutput
#else
#import bevy_pbr::forward_io::VertexOutput
#endif

// 32 bytes; `Instance` of the library.
struct Record {
    row_a: u32,
    row_b: u32,
    frac_blend: u32,
    variant: u32,
    place: vec4<f32>, // x, y, z, heading; the entity's transform says the same
}

struct Vertex {
    @builtin(instance_index) instance_index: u32,
    @location(0) position: vec3<f32>,
#ifdef PREPASS_PIPELINE
#ifdef VERTEX_UVS_A
    @location(1) uv: vec2<f32>,
#endif
#ifdef VERTEX_UVS_B
    @location(2) uv_b: vec2<f32>,
#endif
#ifdef NORMAL_PREPASS_OR_DEFERRED_PREPASS
#ifdef VERTEX_NORMALS
    @location(3) normal: vec3<f32>,
#endif
#ifdef VERTEX_TANGENTS
    @location(4) tangent: vec4<f32>,
#endif
#endif
#ifdef VERTEX_COLORS
    @location(7) color: vec4<f32>,
#endif
#else // PREPASS_PIPELINE
#ifdef VERTEX_NORMALS
    @location(1) normal: vec3<f32>,
#endif
#ifdef VERTEX_UVS_A
    @location(2) uv: vec2<f32>,
#endif
#ifdef VERTEX_UVS_B
    @location(3) uv_b: vec2<f32>,
#endif
#ifdef VERTEX_TANGENTS
    @location(4) tangent: vec4<f32>,
#endif
#ifdef VERTEX_COLORS
    @location(5) color: vec4<f32>,
#endif
#endif // PREPASS_PIPELINE
    @location(10) joints: vec4<u32>,
    @location(11) weights: vec4<f32>,
}

@group(#{MATERIAL_BIND_GROUP}) @binding(100) var<storage, read> records: array<Record>;
// Three rows of a matrix for each of 22 joints of a frame row.
@group(#{MATERIAL_BIND_GROUP}) @binding(101) var<storage, read> rows: array<vec4<f32>>;

// Row i of a joint's matrix between a frame row and the next.
fn between(row: u32, joint: u32, i: u32, frac: f32) -> vec4<f32> {
    let at = 3u * (22u * row + joint) + i;
    // The last row of all is only met with nothing left to the next.
    let next = min(at + 66u, arrayLength(&rows) - 1u);
    return mix(rows[at], rows[next], frac);
}

// From the body at rest to the character's frame on the ground.
fn skin(vertex: Vertex) -> mat4x4<f32> {
    let record = records[mesh_functions::get_tag(vertex.instance_index)];
    let share = unpack2x16unorm(record.frac_blend);
    var m = mat3x4<f32>();
    for (var k = 0; k < 4; k++) {
        let weight = vertex.weights[k];
        if weight == 0.0 {
            continue;
        }
        for (var i = 0u; i < 3u; i++) {
            var row = between(record.row_a, vertex.joints[k], i, share.x);
            if share.y > 0.0 {
                row = mix(row, between(record.row_b, vertex.joints[k], i, share.x), share.y);
            }
            m[i] += weight * row;
        }
    }
    return transpose(mat4x4<f32>(m[0], m[1], m[2], vec4(0.0, 0.0, 0.0, 1.0)));
}

@vertex
fn vertex(vertex: Vertex) -> VertexOutput {
    var out: VertexOutput;
    let world_from_entity = mesh_functions::get_world_from_local(vertex.instance_index);
    let skinned = skin(vertex);
    let world_from_local = world_from_entity * skinned;
    out.world_position = world_from_local * vec4(vertex.position, 1.0);
    out.position = position_world_to_clip(out.world_position.xyz);

#ifdef UNCLIPPED_DEPTH_ORTHO_EMULATION
    out.unclipped_depth = out.position.z;
    out.position.z = min(out.position.z, 1.0);
#endif
#ifdef PREPASS_PIPELINE
#ifdef NORMAL_PREPASS_OR_DEFERRED_PREPASS
#ifdef VERTEX_NORMALS
    out.world_normal = normalize((world_from_local * vec4(vertex.normal, 0.0)).xyz);
#endif
#ifdef VERTEX_TANGENTS
    out.world_tangent = vec4(normalize((world_from_local * vec4(vertex.tangent.xyz, 0.0)).xyz), vertex.tangent.w);
#endif
#endif
#ifdef MOTION_VECTOR_PREPASS
    // The pose of now where it stood then: limbs are not followed.
    let before = mesh_functions::get_previous_world_from_local(vertex.instance_index);
    out.previous_world_position = before * skinned * vec4(vertex.position, 1.0);
#endif
#else // PREPASS_PIPELINE
#ifdef VERTEX_NORMALS
    out.world_normal = normalize((world_from_local * vec4(vertex.normal, 0.0)).xyz);
#endif
#ifdef VERTEX_TANGENTS
    out.world_tangent = vec4(normalize((world_from_local * vec4(vertex.tangent.xyz, 0.0)).xyz), vertex.tangent.w);
#endif
#endif // PREPASS_PIPELINE
#ifdef VERTEX_UVS_A
    out.uv = vertex.uv;
#endif
#ifdef VERTEX_UVS_B
    out.uv_b = vertex.uv_b;
#endif
#ifdef VERTEX_COLORS
    out.color = vertex.color;
#endif
#ifdef VERTEX_OUTPUT_INSTANCE_INDEX
    out.instance_index = vertex.instance_index;
#endif
#ifdef VISIBILITY_RANGE_DITHER
    out.visibility_range_dither =
        mesh_functions::get_visibility_range_dither_level(vertex.instance_index, world_from_entity[3]);
#endif
    return out;
}
