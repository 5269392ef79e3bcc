//! Names of clips.

use super::RetargetSource;
use crate::{error::Warnings, mirror};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Component;

/// Unique names of the clips; where two are the same, as many of their folders in front as tell them apart.
pub fn unique_names(sources: &[RetargetSource], warnings: &mut Warnings) -> Vec<String> {
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
    // Two files of one folder may differ in their extension alone.
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

/// Renames clips whose name is that of another one's mirrored copy.
pub fn rename_mirror_clashes(names: &mut [String], warnings: &mut Warnings) {
    let mut taken: BTreeSet<String> = names.iter().cloned().collect();
    for i in 0..names.len() {
        let original = names[i].strip_suffix(mirror::SUFFIX).filter(|original| taken.contains(*original));
        let Some(original) = original.map(str::to_owned) else { continue };
        let is_free = |name: &String| !taken.contains(name) && !taken.contains(&format!("{name}{}", mirror::SUFFIX));
        let Some(name) = (1..).map(|n| format!("{original}~{n}")).find(is_free) else { continue };
        warnings.push(format!(
            "`{}` is what the mirrored copy of `{original}` is called: the clip of that file is called `{name}`. Rename the \
             file, or leave mirrored files out.",
            names[i]
        ));
        taken.insert(name.clone());
        names[i] = name;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_clip_has_the_name_of_a_mirrored_copy() {
        let mut names = ["walk~mirror", "walk", "walk~1", "run~mirror"].map(str::to_owned);
        let mut warnings = Warnings::default();
        rename_mirror_clashes(&mut names, &mut warnings);
        assert_eq!(names, ["walk~2", "walk", "walk~1", "run~mirror"]);
        let mut all: Vec<String> = names.iter().flat_map(|n| [n.clone(), format!("{n}{}", mirror::SUFFIX)]).collect();
        all.sort();
        all.dedup();
        assert_eq!(all.len(), 8);
    }
}
