//! Compilation of expectations.

use super::{CompileFault, CompileResult, ScenarioCompiler, compile_fault};
use crate::scenario::language::{NameKind, Type};
use crate::scenario::tables::{ExpectationTable, trigger};
use crate::scene::{ExpectConfig, ExpectedQuantity};
use throng_base::text::did_you_mean;

impl ScenarioCompiler<'_> {
    pub(super) fn compile_expectations(&mut self) -> CompileResult<()> {
        self.set_scope(trigger::STARTS);
        for (i, config) in self.scene.expect.iter().enumerate() {
            let table = self.compile_expectation(config, &format!("expect[{i}]"))?;
            self.out.expectations.push(table);
        }
        Ok(())
    }

    fn compile_expectation(&mut self, config: &ExpectConfig, key: &str) -> CompileResult<ExpectationTable> {
        let mut table =
            ExpectationTable { who: if config.who.is_empty() { u64::MAX } else { 0 }, ..Default::default() };
        let is_figure = matches!(config.that, ExpectedQuantity::Figure(_));
        for (g, name) in config.who.iter().enumerate() {
            let key = format!("{key}.who[{g}]");
            if is_figure {
                let titles: Vec<String> =
                    self.scene.groups.iter().enumerate().map(|(g, group)| group.title(g)).collect();
                if !titles.contains(name) {
                    let help = did_you_mean(name, titles.iter().map(String::as_str));
                    return compile_fault(key, format!("there is no group `{name}`.{help}"));
                }
            } else {
                table.who |= 1 << self.name_number(NameKind::Group, name, &key)?;
            }
        }
        if !is_figure && self.out.groups.is_empty() {
            return compile_fault(format!("{key}.that"), "the scene has no agents: expected a `figure`");
        }
        let mut truth =
            |text: &str, word: &str| self.compile_expression(text, Type::Truth, &format!("{key}.that.{word}"));
        match &config.that {
            ExpectedQuantity::Always(text) => table.programs.push(truth(text, "always")?),
            ExpectedQuantity::Never(text) => table.programs.push(truth(text, "never")?),
            ExpectedQuantity::Lasts(text) => table.programs.push(truth(text, "lasts")?),
            ExpectedQuantity::Passes(all) => {
                for (i, text) in all.iter().enumerate() {
                    table.programs.push(truth(text, &format!("passes[{i}]"))?);
                }
            }
            ExpectedQuantity::Amount(text) => {
                table.programs.push(self.compile_expression(text, Type::Number, &format!("{key}.that.amount"))?);
            }
            ExpectedQuantity::News(name) => {
                table.number = self.name_number(NameKind::Event, name, &format!("{key}.that.news"))?;
            }
            ExpectedQuantity::Queue(name) => {
                table.number = self.name_number(NameKind::Place, name, &format!("{key}.that.queue"))?;
                if !self.out.places[usize::from(table.number)].is_queue {
                    return compile_fault(format!("{key}.that.queue"), format!("`{name}` has no queue"));
                }
            }
            ExpectedQuantity::Wait(name) => {
                table.number = self.name_number(NameKind::Service, name, &format!("{key}.that.wait"))?;
            }
            ExpectedQuantity::Mutual(name) => {
                let known: Vec<&str> = self.out.primitives.primitive_names().collect();
                let found = known.iter().position(|n| n == name).ok_or_else(|| {
                    let why = format!("there is no action `{name}` that takes time.{}", did_you_mean(name, known));
                    CompileFault { key: format!("{key}.that.mutual"), at: None, why }
                });
                table.number = found? as u16;
            }
            ExpectedQuantity::Figure(_) => {}
        }
        Ok(table)
    }
}
