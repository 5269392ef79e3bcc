//! What clips are called.

use super::Source;
use crate::error::Warnings;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Component;

/// The clips' names; where two are the same, with as many of their folders in front as tell them apart.
pub fn unique_names(sources: &[Source], warnings: &mut Warnings) -> Vec<String> {
    let name = |i: usize, depth: usize| {
        let clip = sources[i].clip;
        let above = clip.path.components().count().saturating_sub(clip.name.split('/').count());
        let folders = clip.path.components().take(above).filter(|c| matches!(c, Component::Normal(_)));
        let folders: Vec<String> = folders.map(|c| c.as_os_str().to_string_lossy().into_owned()).collect();
        let shown = &folders[folders.len().saturating_sub(depth)..];
        shown.iter().chain([&clip.name]).cloned().collect::<Vec<_>>().join("/")
    };
    let given: Vec<String> = (0..sources.len()).map(|i| name(i, 0)).collect();
    let mut names = given.clone();
    for depth in 1..8 {
        let mut seen = BTreeMap::<String, usize>::new();
        names.iter().for_each(|n| *seen.entry(n.clone()).or_default() += 1);
        for i in 0..names.len() {
            if seen[&names[i]] > 1 {
                names[i] = name(i, depth);
            }
        }
        if seen.values().all(|&n| n == 1) {
            break;
        }
    }
    // Two files of one folder that differ in their extension alone.
    let mut taken = BTreeSet::new();
    for (i, name) in names.iter_mut().enumerate() {
        let mut numbered = (i..).map(|n| format!("{name}~{n}"));
        if !taken.insert(name.clone()) {
            *name = numbered.find(|n| taken.insert(n.clone())).unwrap_or_default();
        }
    }
    let mut clashes = BTreeMap::<&String, Vec<&String>>::new();
    (0..names.len())
        .filter(|&i| names[i] != given[i])
        .for_each(|i| clashes.entry(&given[i]).or_default().push(&names[i]));
    for (name, called) in clashes {
        let called: Vec<String> = called.iter().map(|n| format!("`{n}`")).collect();
        warnings.push(format!("several files have the name `{name}`: their clips are called {}.", called.join(", ")));
    }
    names
}
