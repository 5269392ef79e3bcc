// A character to draw, and what all bodies share.

struct Instance {
    root: vec4<f32>, // x, z, sine and cosine of the heading
    colour: u32,
    is_selected: u32,
    row_a: u32, // of a record; FROM_PALETTE where the pose is in the palette
    row_b: u32,
    frac_blend: u32,
    y: f32,
    worn: u32, // first matrix of a mesh of the user's own
    look: u32, // bits of the colours of clothes; 0 for everybody's
}

const FROM_PALETTE: u32 = 0xffffffffu;

struct Skinned {
    position: vec3<f32>,
    normal: vec3<f32>,
}

fn turned(p: vec3<f32>, root: vec4<f32>) -> vec3<f32> {
    return vec3(root.w * p.x + root.z * p.z, p.y, root.w * p.z - root.z * p.x);
}

// A colour with the edge of what is selected; `facing` is 1 where the surface faces the eye.
fn edged(colour: vec3<f32>, facing: f32, is_selected: u32) -> vec3<f32> {
    if is_selected == 0u {
        return colour;
    }
    return mix(colour, scene.selected.rgb, 0.12 + 0.88 * smoothstep(0.35, 0.85, 1.0 - facing));
}
