//! Statistics of a scene: what its services and sources have done.

use crate::Simulation;
use crate::scenario::{AgentBrains, ServiceStatistics, SourceStatistics};
use serde::Serialize;

/// Statistics of a simulation so far.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SceneStatistics {
    /// Statistics of each service.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub services: Vec<ServiceStatistics>,
    /// Statistics of each group with a source.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub sources: Vec<SourceStatistics>,
}

impl SceneStatistics {
    /// True where there is neither a service nor a source.
    pub fn is_empty(&self) -> bool {
        self.services.is_empty() && self.sources.is_empty()
    }
}

impl Simulation {
    /// Statistics of the services and sources of its scene so far.
    pub fn statistics(&self) -> SceneStatistics {
        let of = |brains: &AgentBrains| SceneStatistics {
            services: brains.service_statistics(self.time_s()),
            sources: brains.source_statistics(),
        };
        self.brains().map(of).unwrap_or_default()
    }
}
