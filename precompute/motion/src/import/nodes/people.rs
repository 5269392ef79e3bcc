//! Search for the skeletons of people among the nodes of a scene.

use super::super::source::{MAX_JOINTS, MAX_NAME};
use super::RigScene;
use crate::{error::ensure, raw::children_of};
use std::collections::{BTreeMap, BTreeSet};

/// Most levels of nodes; a skeleton has about thirty.
const MAX_DEPTH: usize = 512;
/// Most skeletons of a file.
const MAX_PEOPLE: usize = 100;
/// Least number of joints of a person: smaller skeletons are cameras, doors, weapons.
const MIN_JOINTS: usize = 8;

/// A skeleton in a scene.
pub(super) struct ScenePerson {
    /// Name: that of the node above the skeleton, or of its root.
    pub name: String,
    /// Nodes above the root, outermost first.
    pub above: Vec<usize>,
    /// Nodes, parents first.
    pub joints: Vec<usize>,
    /// Index of each joint's parent among the joints (joints.len()).
    pub parents: Vec<Option<usize>>,
}

/// Finds the skeletons: of each skin, the nodes that carry it; where there is no skin, the nodes that animations move.
///
/// Skins whose joints are below those of another one belong to one body, as clothes do.
///
/// # Errors
/// A node that is not in a tree, or the missing part.
pub(super) fn find_people(scene: &RigScene<'_>) -> Result<Vec<ScenePerson>, String> {
    let tree = NodeTree::new(scene)?;
    let moved: BTreeSet<usize> = scene.animations.iter().flat_map(|a| a.moved()).copied().collect();
    let mut tops = BTreeMap::<usize, Vec<usize>>::new();
    let mut add = |joints: &[usize]| {
        if let Some(top) = joints.iter().copied().reduce(|a, b| tree.common_ancestor(a, b).unwrap_or(a)) {
            tops.entry(top).or_default().extend(joints);
        }
    };
    if scene.skins.is_empty() {
        let mut by_root = BTreeMap::<usize, Vec<usize>>::new();
        moved.iter().for_each(|&node| by_root.entry(tree.path_up(node).last().unwrap_or(node)).or_default().push(node));
        by_root.values().for_each(|nodes| add(nodes));
    }
    for skin in &scene.skins {
        if let Some(n) = skin.iter().find(|&&n| n >= scene.nodes.len()) {
            return Err(format!("a skin names node {n} of {}: expected less", scene.nodes.len()));
        }
        add(skin);
    }
    let carriers: BTreeSet<usize> = scene.skins.iter().flatten().copied().collect();
    let outermost = tops.keys().filter(|&&top| !tree.path_up(top).skip(1).any(|n| tops.contains_key(&n)));
    let people =
        outermost.take(MAX_PEOPLE).map(|&top| tree.person(top, &carriers, &moved)).collect::<Result<Vec<_>, _>>()?;
    let most = people.iter().map(|p| p.joints.len()).max();
    let people: Vec<ScenePerson> = people.into_iter().filter(|p| p.joints.len() >= MIN_JOINTS).collect();
    match people.is_empty() {
        true => Err(format!(
            "no skeleton is there: expected at least {MIN_JOINTS} joints of a skin, or nodes that an animation moves, \
             found {}",
            most.unwrap_or(0)
        )),
        false => Ok(people),
    }
}

/// Nodes of a scene, with the nodes below each of them.
struct NodeTree<'a, 'b> {
    scene: &'a RigScene<'b>,
    children: Vec<Vec<usize>>,
    depth: Vec<usize>,
}

impl<'a, 'b> NodeTree<'a, 'b> {
    fn new(scene: &'a RigScene<'b>) -> Result<Self, String> {
        let n = scene.nodes.len();
        let children = children_of(scene.nodes.iter().map(|node| node.parent));
        let mut tree = Self { scene, children, depth: vec![0; n] };
        let mut open: Vec<usize> = (0..n).filter(|&i| scene.nodes[i].parent.is_none()).collect();
        let mut seen = 0;
        while let Some(i) = open.pop() {
            seen += 1;
            if tree.depth[i] > MAX_DEPTH {
                return Err(format!("node `{}`: expected at most {MAX_DEPTH} levels of nodes", scene.nodes[i].name));
            }
            for k in 0..tree.children[i].len() {
                let child = tree.children[i][k];
                tree.depth[child] = tree.depth[i] + 1;
                open.push(child);
            }
        }
        ensure(seen >= n, || format!("{} nodes are below themselves: expected a tree", n - seen))?;
        Ok(tree)
    }

    /// A node and those above it, nearest first.
    fn path_up(&self, node: usize) -> impl Iterator<Item = usize> + '_ {
        std::iter::successors(Some(node), |&n| self.scene.nodes[n].parent)
    }

    /// The nearest node that is above both, or is one of them.
    fn common_ancestor(&self, mut a: usize, mut b: usize) -> Option<usize> {
        while a != b {
            let deeper = if self.depth[a] >= self.depth[b] { &mut a } else { &mut b };
            *deeper = self.scene.nodes[*deeper].parent?;
        }
        Some(a)
    }

    /// A node and all below it, parents first.
    fn subtree(&self, top: usize) -> Vec<usize> {
        let mut below = Vec::new();
        let mut open = vec![top];
        while let Some(n) = open.pop() {
            below.push(n);
            open.extend(self.children[n].iter().rev());
        }
        below
    }

    /// The skeleton at or below a node: nodes that carry a skin, are moved or lead there, and all others that show nothing,
    /// such as ends of chains.
    fn person(&self, top: usize, carriers: &BTreeSet<usize>, moved: &BTreeSet<usize>) -> Result<ScenePerson, String> {
        let mut leads = BTreeSet::from([top]);
        for &n in self.subtree(top).iter().rev() {
            if carriers.contains(&n) || moved.contains(&n) || self.children[n].iter().any(|c| leads.contains(c)) {
                leads.insert(n);
            }
        }
        // A node that moves all of a skeleton and is no part of it, such as an armature, is above it.
        let mut top = top;
        let leading = |n: usize| self.children[n].iter().filter(|c| leads.contains(c)).collect::<Vec<_>>();
        while let (false, [only]) = (carriers.contains(&top), &leading(top)[..]) {
            top = **only;
        }
        let parent = |n: usize| self.scene.nodes[n].parent;
        let mut places = BTreeMap::new();
        let (mut joints, mut parents) = (Vec::new(), Vec::new());
        for n in self.subtree(top) {
            let above = parent(n).and_then(|p| places.get(&p).copied());
            if leads.contains(&n) || (above.is_some() && !self.scene.nodes[n].shows) {
                places.insert(n, joints.len());
                joints.push(n);
                parents.push(above);
            }
        }
        let name = |n: usize| self.scene.nodes[n].name.clone();
        if joints.len() > MAX_JOINTS {
            return Err(format!("node `{}`: expected at most {MAX_JOINTS} joints, found {}", name(top), joints.len()));
        }
        let long = |n: &usize| self.scene.nodes[*n].name.len() > MAX_NAME;
        if let Some(n) = joints.iter().copied().chain(parent(top)).find(long) {
            return Err(format!("nodes[{n}]: expected a name of at most {MAX_NAME} bytes, found a longer one"));
        }
        let mut above: Vec<usize> = self.path_up(top).skip(1).collect();
        above.reverse();
        Ok(ScenePerson { name: name(above.last().copied().unwrap_or(top)), above, joints, parents })
    }
}
