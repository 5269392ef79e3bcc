//! Writes takes as USD text (`.usda`) with UsdSkel: skeletons, animations and plain bodies.
//!
//! Plain, every character is a skeleton root of its own with its animation, which every reader keeps. Instanced, as
//! renderers of crowds want it, characters are instances of one model each of which is bound to an animation.

use super::take::{PRESENCE_TRACK, Take, TakeActor};
use glam::Vec3;
use std::fmt::{Display, Write as _};
use std::io::{self, Write};
use throng_core::{Joint, NUM_JOINTS, PlainBody, Skeleton};

/// Name of the only root prim.
const ROOT: &str = "Crowd";
/// Mark of prims that take part in skinning.
const SKINNED: &str = "prepend apiSchemas = [\"SkelBindingAPI\"]";

/// Writes a take. Clips of a library are animations of one figure, which plays the first.
///
/// - `instances`: characters are instances of a model (no effect on clips).
///
/// # Errors
/// Errors of `out`.
pub fn usda(take: &Take, instances: bool, out: &mut dyn Write) -> io::Result<()> {
    let mut skeletons: Vec<&Skeleton> = Vec::new();
    for actor in take.actors() {
        if !skeletons.contains(&&actor.skeleton) {
            skeletons.push(&actor.skeleton);
        }
    }
    let number = |actor: &TakeActor| skeletons.iter().position(|s| **s == actor.skeleton).unwrap_or(0);
    let instances = instances && !take.is_library();
    write_head(take, out)?;
    writeln!(out, "def Xform \"{ROOT}\"\n{{")?;
    for (i, skeleton) in skeletons.iter().enumerate() {
        if instances {
            writeln!(out, "    class SkelRoot \"Model_{i}\" (\n        {SKINNED}\n    )\n    {{")?;
            write_skeleton(skeleton, None, 8, out)?;
            write_body(skeleton, "Body", Some(&format!("/{ROOT}/Model_{i}/Skeleton")), out)?;
            writeln!(out, "    }}\n")?;
        } else {
            write_body(skeleton, &format!("Body_{i}"), None, out)?;
        }
    }
    if instances {
        writeln!(out, "    def Scope \"Animations\"\n    {{")?;
        for a in 0..take.actors().len() {
            write_animation(take, a, &ident(take, a), 8, out)?;
        }
        writeln!(out, "    }}\n")?;
    }
    for (a, actor) in take.actors().iter().enumerate() {
        if instances {
            write_instance(take, a, number(actor), out)?;
        } else if a == 0 || !take.is_library() {
            write_character(take, a, number(actor), out)?;
        }
    }
    writeln!(out, "}}")
}

/// Name of an actor as a prim.
fn ident(take: &Take, actor: usize) -> String {
    if take.is_library() { format!("clip_{actor}") } else { format!("character_{}", take.actors()[actor].number) }
}

fn write_head(take: &Take, out: &mut dyn Write) -> io::Result<()> {
    let (rate, last) = (take.rate_hz(), take.longest().saturating_sub(1));
    writeln!(out, "#usda 1.0\n(\n    defaultPrim = \"{ROOT}\"\n    doc = \"Throng {}\"", env!("CARGO_PKG_VERSION"))?;
    writeln!(out, "    endTimeCode = {last}\n    framesPerSecond = {rate}\n    metersPerUnit = 1")?;
    writeln!(out, "    startTimeCode = 0\n    timeCodesPerSecond = {rate}\n    upAxis = \"Y\"\n)\n")
}

/// A character with a skeleton and an animation of its own.
fn write_character(take: &Take, a: usize, body: usize, out: &mut dyn Write) -> io::Result<()> {
    let (name, actor) = (ident(take, a), &take.actors()[a]);
    writeln!(out, "    def SkelRoot \"{name}\" (\n        {SKINNED}")?;
    writeln!(out, "        displayName = {}\n    )\n    {{", quoted(&actor.name))?;
    write_visibility(take, a, out)?;
    let animation = if take.is_library() { ident(take, 0) } else { "Animation".into() };
    write_skeleton(&actor.skeleton, Some(&format!("/{ROOT}/{name}/{animation}")), 8, out)?;
    if take.is_library() {
        for clip in 0..take.actors().len() {
            write_animation(take, clip, &ident(take, clip), 8, out)?;
        }
    } else {
        write_animation(take, a, "Animation", 8, out)?;
    }
    let references = format!("prepend references = </{ROOT}/Body_{body}>");
    writeln!(out, "        def Mesh \"Body\" (\n            {SKINNED}")?;
    writeln!(out, "            {references}\n        )\n        {{")?;
    writeln!(out, "            rel skel:skeleton = </{ROOT}/{name}/Skeleton>\n        }}\n    }}\n")
}

/// A character that is an instance of a model, bound to its animation.
fn write_instance(take: &Take, a: usize, model: usize, out: &mut dyn Write) -> io::Result<()> {
    let name = ident(take, a);
    writeln!(out, "    def SkelRoot \"{name}\" (\n        {SKINNED}")?;
    writeln!(out, "        displayName = {}", quoted(&take.actors()[a].name))?;
    writeln!(out, "        instanceable = true\n        prepend references = </{ROOT}/Model_{model}>\n    )\n    {{")?;
    write_visibility(take, a, out)?;
    writeln!(out, "        rel skel:animationSource = </{ROOT}/Animations/{name}>\n    }}\n")
}

/// Writes when an actor is absent, if it ever is.
fn write_visibility(take: &Take, a: usize, out: &mut dyn Write) -> io::Result<()> {
    if !take.actors()[a].is_ever_away {
        return Ok(());
    }
    writeln!(out, "        token visibility.timeSamples = {{")?;
    let (mut frame, mut before) = (0, None);
    take.scratch().track(a, PRESENCE_TRACK, |there| {
        for t in there {
            if before.replace(*t) != Some(*t) {
                let word = if *t > 0.5 { "inherited" } else { "invisible" };
                writeln!(out, "            {frame}: \"{word}\",")?;
            }
            frame += 1;
        }
        Ok(())
    })?;
    writeln!(out, "        }}")
}

/// The skeleton in its rest pose.
fn write_skeleton(skeleton: &Skeleton, animation: Option<&str>, depth: usize, out: &mut dyn Write) -> io::Result<()> {
    let tab = " ".repeat(depth);
    writeln!(out, "{tab}def Skeleton \"Skeleton\" (\n{tab}    {SKINNED}\n{tab})\n{tab}{{")?;
    let matrix = |p: Vec3| format!("( (1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), ({}, {}, {}, 1) )", p.x, p.y, p.z);
    let bind = list(skeleton.rest_positions().iter().map(|p| matrix(*p)));
    let rest = list(skeleton.offsets.iter().map(|p| matrix(*p)));
    writeln!(out, "{tab}    uniform matrix4d[] bindTransforms = {bind}")?;
    writeln!(out, "{tab}    uniform token[] joints = {}", joint_paths())?;
    writeln!(out, "{tab}    uniform matrix4d[] restTransforms = {rest}")?;
    if let Some(animation) = animation {
        writeln!(out, "{tab}    rel skel:animationSource = <{animation}>")?;
    }
    writeln!(out, "{tab}}}\n")
}

/// Rotations and translations of all joints over time.
fn write_animation(take: &Take, a: usize, name: &str, depth: usize, out: &mut dyn Write) -> io::Result<()> {
    let tab = " ".repeat(depth);
    writeln!(out, "{tab}def SkelAnimation \"{name}\" (\n{tab}    displayName = {}", quoted(&take.actors()[a].name))?;
    writeln!(out, "{tab})\n{tab}{{\n{tab}    uniform token[] joints = {}", joint_paths())?;
    writeln!(out, "{tab}    quatf[] rotations.timeSamples = {{")?;
    take.poses(a, |frame, pose, _| {
        let turns = list(pose.rotations.iter().map(|r| format!("({}, {}, {}, {})", r.w, r.x, r.y, r.z)));
        writeln!(out, "{tab}        {frame}: {turns},")
    })?;
    writeln!(out, "{tab}    }}\n{tab}    half3[] scales = {}", list((0..NUM_JOINTS).map(|_| "(1, 1, 1)")))?;
    writeln!(out, "{tab}    float3[] translations.timeSamples = {{")?;
    take.poses(a, |frame, pose, _| {
        let places = list(pose.translations.iter().map(|t| format!("({}, {}, {})", t.x, t.y, t.z)));
        writeln!(out, "{tab}        {frame}: {places},")
    })?;
    writeln!(out, "{tab}    }}\n{tab}}}\n")
}

/// The plain body, carried by the skeleton that is bound to it or around it.
fn write_body(skeleton: &Skeleton, name: &str, bound: Option<&str>, out: &mut dyn Write) -> io::Result<()> {
    // A body without a binding is written for others to refer to.
    let (how, depth) = if bound.is_some() { ("def", 8) } else { ("class", 4) };
    let (tab, body) = (" ".repeat(depth), PlainBody::fine(skeleton));
    let vector = |v: &Vec3| format!("({}, {}, {})", v.x, v.y, v.z);
    let low = body.positions.iter().copied().fold(Vec3::INFINITY, Vec3::min);
    let high = body.positions.iter().copied().fold(Vec3::NEG_INFINITY, Vec3::max);
    writeln!(out, "{tab}{how} Mesh \"{name}\" (\n{tab}    {SKINNED}\n{tab})\n{tab}{{")?;
    writeln!(out, "{tab}    float3[] extent = [{}, {}]", vector(&low), vector(&high))?;
    writeln!(out, "{tab}    int[] faceVertexCounts = {}", list(body.triangles.iter().map(|_| 3)))?;
    writeln!(out, "{tab}    int[] faceVertexIndices = {}", list(body.triangles.iter().flatten()))?;
    let normals = list(body.normals.iter().map(vector));
    writeln!(out, "{tab}    normal3f[] normals = {normals} (\n{tab}        interpolation = \"vertex\"\n{tab}    )")?;
    writeln!(out, "{tab}    point3f[] points = {}", list(body.positions.iter().map(vector)))?;
    writeln!(out, "{tab}    color3f[] primvars:displayColor = [(0.55, 0.6, 0.68)]")?;
    let unit = "( (1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1) )";
    writeln!(out, "{tab}    matrix4d primvars:skel:geomBindTransform = {unit}")?;
    let each = format!("(\n{tab}        elementSize = 1\n{tab}        interpolation = \"vertex\"\n{tab}    )");
    writeln!(out, "{tab}    int[] primvars:skel:jointIndices = {} {each}", list(&body.joints))?;
    writeln!(out, "{tab}    float[] primvars:skel:jointWeights = {} {each}", list(body.joints.iter().map(|_| 1)))?;
    if let Some(skeleton) = bound {
        writeln!(out, "{tab}    rel skel:skeleton = <{skeleton}>")?;
    }
    writeln!(out, "{tab}    uniform token subdivisionScheme = \"none\"\n{tab}}}\n")
}

/// Paths of all joints, such as `hips/spine`.
fn joint_paths() -> String {
    let path = |joint: Joint| {
        let mut names: Vec<&str> = std::iter::successors(Some(joint), |j| j.parent()).map(Joint::name).collect();
        names.reverse();
        format!("\"{}\"", names.join("/"))
    };
    list(Joint::ALL.into_iter().map(path))
}

fn list<T: Display>(items: impl IntoIterator<Item = T>) -> String {
    let mut text = String::from("[");
    for (i, item) in items.into_iter().enumerate() {
        _ = write!(text, "{}{item}", if i > 0 { ", " } else { "" });
    }
    text + "]"
}

/// A text in the notation of USD.
fn quoted(text: &str) -> String {
    let plain: String = text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    format!("\"{}\"", plain.replace('\\', "\\\\").replace('"', "\\\""))
}
