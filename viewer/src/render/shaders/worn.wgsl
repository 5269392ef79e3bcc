// Linear blend skinning of a mesh of the user's own, from matrices of its own joints.

struct BodyVertex {
    @location(0) position: vec3<f32>,
    @location(1) colour: vec4<f32>,
    @location(2) normal: vec3<f32>,
    @location(3) joints: vec4<u32>,
    @location(4) weights: vec4<f32>,
    @location(5) character: u32,
    @location(6) place: vec2<f32>,
    @location(7) @interpolate(flat) layer: u32,
}

@group(1) @binding(0) var<storage, read> matrices: array<vec4<f32>>;
@group(1) @binding(1) var<storage, read> instances: array<Instance>;

fn skin(v: BodyVertex) -> Skinned {
    var position = vec3(0.0);
    var normal = vec3(0.0);
    let first = instances[v.character].worn;
    for (var i = 0; i < 4; i++) {
        let weight = v.weights[i];
        // The strongest come first.
        if weight == 0.0 {
            break;
        }
        let at = 3u * (first + v.joints[i]);
        let r0 = matrices[at];
        let r1 = matrices[at + 1u];
        let r2 = matrices[at + 2u];
        let p = vec4(v.position, 1.0);
        position += weight * vec3(dot(r0, p), dot(r1, p), dot(r2, p));
        normal += weight * vec3(dot(r0.xyz, v.normal), dot(r1.xyz, v.normal), dot(r2.xyz, v.normal));
    }
    let length = length(normal);
    let root = instances[v.character].root;
    let y = instances[v.character].y;
    let turned_normal = turned(normal / max(length, 1e-12), root);
    return Skinned(turned(position, root) + vec3(root.x, y, root.y), turned_normal);
}
