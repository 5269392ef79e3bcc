//! Agents and characters with policies among the characters of a simulation.

use glam::Vec3;
use throng_core::characters::PolicyCharacters;
use throng_crowd::Crowd;
use throng_simulation::{AnyCharacterGroup, Simulation, agents::world_vector};

/// Characters with policies of a character group; none for others.
pub fn policy_characters(group: &AnyCharacterGroup) -> Option<&PolicyCharacters> {
    match group {
        AnyCharacterGroup::Policy(p) => Some(p.practice().boxers()),
        AnyCharacterGroup::Travel(t) => Some(t.people()),
        AnyCharacterGroup::Sparring(s) => Some(s.sparring().boxers()),
        _ => None,
    }
}

/// Crowd of a character group of agents; none for others.
pub fn agents_crowd(group: &AnyCharacterGroup) -> Option<&Crowd> {
    match group {
        AnyCharacterGroup::Ground(agents) => Some(agents.crowd()),
        AnyCharacterGroup::Air(agents) => Some(agents.crowd()),
        _ => None,
    }
}

/// Number of the first agent among all characters; none in a scene without agents.
pub fn first_agent(sim: &Simulation) -> Option<usize> {
    let is_of_agents = |group: usize| agents_crowd(&sim.character_groups()[group]).is_some();
    sim.groups().iter().find(|g| is_of_agents(g.character_group)).map(|g| g.characters.start)
}

/// Corners of the path of a character with a goal, from its start to the goal; none for other characters (m).
pub fn agent_path(sim: &Simulation, who: usize) -> Vec<Vec3> {
    match sim.locate(who) {
        (AnyCharacterGroup::Ground(agents), member) => {
            agents.layout().paths[member].iter().map(|&p| world_vector(p)).collect()
        }
        (AnyCharacterGroup::Travel(t), member) => t.layout().paths[member].iter().map(|&p| world_vector(p)).collect(),
        (AnyCharacterGroup::Air(agents), member) => agents.layout().paths[member].clone(),
        _ => Vec::new(),
    }
}
