// Linear blend skinning from the matrix palette, and the planar root.

struct Instance {
    root: vec4<f32>, // x, z, sine and cosine of the heading
    colour: u32,
    emphasis: u32,
    unused: vec2<u32>,
}

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

struct Skinned {
    position: vec3<f32>,
    normal: vec3<f32>,
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
        let row = 3u * (22u * v.character + joint);
        let r0 = palette[row];
        let r1 = palette[row + 1u];
        let r2 = palette[row + 2u];
        let p = vec4(v.position - scene.rest[joint].xyz, 1.0);
        position += weight * vec3(dot(r0, p), dot(r1, p), dot(r2, p));
        normal += weight * vec3(dot(r0.xyz, v.normal), dot(r1.xyz, v.normal), dot(r2.xyz, v.normal));
    }
    let root = instances[v.character].root;
    return Skinned(turned(position, root) + vec3(root.x, 0.0, root.y), turned(normal, root));
}

fn turned(p: vec3<f32>, root: vec4<f32>) -> vec3<f32> {
    return vec3(root.w * p.x + root.z * p.z, p.y, root.w * p.z - root.z * p.x);
}
