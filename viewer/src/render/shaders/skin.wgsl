// Linear blend skinning from the matrix palette or from frame rows, and the planar root.

struct BodyVertex {
    @location(0) position: vec3<f32>,
    @location(1) part: u32,
    @location(2) normal: vec3<f32>,
    @location(3) joints: vec4<u32>,
    @location(4) weights: vec4<f32>,
    @location(5) character: u32,
}

@group(1) @binding(0) var<storage, read> palette: array<vec4<f32>>;
@group(1) @binding(1) var<storage, read> instances: array<Instance>;
// Poses of all frame rows of the bundle.
@group(1) @binding(2) var<storage, read> rows: array<vec4<f32>>;

// Row i of a joint's matrix between a frame row and the next.
fn between(row: u32, joint: u32, i: u32, frac: f32) -> vec4<f32> {
    let at = 3u * (22u * row + joint) + i;
    // The last row of all is only met with nothing left to the next.
    let next = min(at + 66u, arrayLength(&rows) - 1u);
    return mix(rows[at], rows[next], frac);
}

// Row i of a joint's matrix.
fn matrix_row(number: u32, joint: u32, i: u32) -> vec4<f32> {
    let instance = &instances[number];
    let row_a = (*instance).row_a;
    if row_a == FROM_PALETTE {
        return palette[3u * (22u * number + joint) + i];
    }
    let share = unpack2x16unorm((*instance).frac_blend);
    let own = between(row_a, joint, i, share.x);
    if share.y == 0.0 {
        return own;
    }
    return mix(own, between((*instance).row_b, joint, i, share.x), share.y);
}

fn skin(v: BodyVertex) -> Skinned {
    var position = vec3(0.0);
    var normal = vec3(0.0);
    for (var i = 0; i < 4; i++) {
        let weight = v.weights[i];
        // The strongest come first.
        if weight == 0.0 {
            break;
        }
        let joint = v.joints[i];
        let r0 = matrix_row(v.character, joint, 0u);
        let r1 = matrix_row(v.character, joint, 1u);
        let r2 = matrix_row(v.character, joint, 2u);
        let p = vec4(v.position - scene.rest[joint].xyz, 1.0);
        position += weight * vec3(dot(r0, p), dot(r1, p), dot(r2, p));
        normal += weight * vec3(dot(r0.xyz, v.normal), dot(r1.xyz, v.normal), dot(r2.xyz, v.normal));
    }
    let root = instances[v.character].root;
    let y = instances[v.character].y;
    return Skinned(turned(position, root) + vec3(root.x, y, root.y), turned(normal, root));
}
