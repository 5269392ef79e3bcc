//! Deserializer of structs from parsed TOML. The one of the `toml` crate compiles the code of every struct four times (for
//! tables, spans, dates and values), this one once.

use crate::error::ensure;
use serde::de::value::StrDeserializer;
use serde::de::{DeserializeSeed, Deserializer, EnumAccess, Error as _};
use serde::de::{MapAccess, SeqAccess, VariantAccess, Visitor};
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeString, DeValue};

/// Fault of a text, with its place where that is known.
#[derive(Debug, thiserror::Error)]
#[error("{why}")]
pub(super) struct TomlFault {
    pub why: String,
    pub span: Option<Range<usize>>,
}

impl TomlFault {
    /// Fault with a place, which stays as it is where it has one already.
    fn with_span(self, span: &Range<usize>) -> Self {
        Self { span: self.span.or_else(|| Some(span.clone())), ..self }
    }
}

impl serde::de::Error for TomlFault {
    fn custom<T: std::fmt::Display>(why: T) -> Self {
        Self { why: why.to_string(), span: None }
    }
}

/// Value with its range of bytes in the text.
pub(super) struct SpannedValue<'t> {
    pub value: &'t DeValue<'t>,
    pub span: Range<usize>,
}

impl<'t> From<&'t Spanned<DeValue<'t>>> for SpannedValue<'t> {
    fn from(value: &'t Spanned<DeValue<'t>>) -> Self {
        Self { span: value.span(), value: value.get_ref() }
    }
}

type Names = &'static [&'static str];
type Entries<'t> = dyn Iterator<Item = (&'t Spanned<DeString<'t>>, &'t Spanned<DeValue<'t>>)> + 't;

impl<'de> Deserializer<'de> for SpannedValue<'_> {
    type Error = TomlFault;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, TomlFault> {
        let span = self.span;
        match self.value {
            DeValue::String(s) => visitor.visit_str(s),
            DeValue::Integer(i) => match i64::from_str_radix(i.as_str(), i.radix()) {
                Ok(value) => visitor.visit_i64(value),
                Err(_) => match u64::from_str_radix(i.as_str(), i.radix()) {
                    Ok(value) => visitor.visit_u64(value),
                    Err(_) => Err(TomlFault::custom(format!("{} needs more than 64 bits", i.as_str()))),
                },
            },
            DeValue::Float(f) => match f.as_str().parse::<f64>() {
                Ok(value) if value.is_finite() || f.as_str().contains(['i', 'n']) => visitor.visit_f64(value),
                _ => Err(TomlFault::custom(format!("{} is beyond the range of numbers", f.as_str()))),
            },
            DeValue::Boolean(b) => visitor.visit_bool(*b),
            DeValue::Datetime(d) => visitor.visit_str(&d.to_string()),
            DeValue::Array(items) => visitor.visit_seq(ItemReader(items.iter())),
            DeValue::Table(table) => visitor.visit_map(FieldReader { rest: Box::new(table.iter()), value: None }),
        }
        .map_err(|e| e.with_span(&span))
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, TomlFault> {
        visitor.visit_some(self)
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(self, _: &'static str, visitor: V) -> Result<V::Value, TomlFault> {
        visitor.visit_newtype_struct(self)
    }

    /// Reads a string as a variant without content, and a table with one key as a variant with content.
    fn deserialize_enum<V: Visitor<'de>>(self, _: &'static str, _: Names, visitor: V) -> Result<V::Value, TomlFault> {
        let span = self.span.clone();
        match self.value {
            DeValue::String(name) => visitor.visit_enum(VariantReader { name, span: self.span, content: None }),
            DeValue::Table(table) if table.len() == 1 => {
                let (name, content) = table.iter().next().expect("one");
                let (span, content) = (name.span(), Some(content.into()));
                visitor.visit_enum(VariantReader { name: name.get_ref(), span, content })
            }
            DeValue::Table(t) => Err(TomlFault::custom(format!("expected a table with one key, found {}", t.len()))),
            _ => Err(TomlFault::custom("expected a string, or a table with one key")),
        }
        .map_err(|e| e.with_span(&span))
    }

    serde::forward_to_deserialize_any! {
        bool u8 u16 u32 u64 u128 i8 i16 i32 i64 i128 f32 f64 char str string seq bytes byte_buf map unit
        ignored_any unit_struct tuple_struct tuple identifier struct
    }
}

struct ItemReader<'t>(std::slice::Iter<'t, Spanned<DeValue<'t>>>);

impl<'de> SeqAccess<'de> for ItemReader<'_> {
    type Error = TomlFault;

    fn next_element_seed<T: DeserializeSeed<'de>>(&mut self, seed: T) -> Result<Option<T::Value>, TomlFault> {
        let Some(item) = self.0.next() else { return Ok(None) };
        seed.deserialize(SpannedValue::from(item)).map(Some).map_err(|e| e.with_span(&item.span()))
    }

    fn size_hint(&self) -> Option<usize> {
        Some(self.0.len())
    }
}

struct FieldReader<'t> {
    rest: Box<Entries<'t>>,
    value: Option<SpannedValue<'t>>,
}

impl<'de> MapAccess<'de> for FieldReader<'_> {
    type Error = TomlFault;

    fn next_key_seed<K: DeserializeSeed<'de>>(&mut self, seed: K) -> Result<Option<K::Value>, TomlFault> {
        let Some((key, value)) = self.rest.next() else { return Ok(None) };
        self.value = Some(value.into());
        seed.deserialize(StrDeserializer::new(key.get_ref())).map(Some).map_err(|e: TomlFault| e.with_span(&key.span()))
    }

    fn next_value_seed<V: DeserializeSeed<'de>>(&mut self, seed: V) -> Result<V::Value, TomlFault> {
        let value = self.value.take().expect("a key was read");
        let span = value.span.clone();
        seed.deserialize(value).map_err(|e| e.with_span(&span))
    }
}

struct VariantReader<'t> {
    name: &'t str,
    span: Range<usize>,
    content: Option<SpannedValue<'t>>,
}

impl<'de> EnumAccess<'de> for VariantReader<'_> {
    type Error = TomlFault;
    type Variant = Self;

    fn variant_seed<V: DeserializeSeed<'de>>(self, seed: V) -> Result<(V::Value, Self), TomlFault> {
        let name = StrDeserializer::new(self.name);
        let variant = seed.deserialize(name).map_err(|e: TomlFault| e.with_span(&self.span))?;
        Ok((variant, self))
    }
}

impl<'t> VariantReader<'t> {
    fn require_content(self) -> Result<SpannedValue<'t>, TomlFault> {
        self.content.ok_or_else(|| TomlFault::custom(format!("`{0}` needs content: {{ {0} = ... }}", self.name)))
    }
}

impl<'de> VariantAccess<'de> for VariantReader<'_> {
    type Error = TomlFault;

    fn unit_variant(self) -> Result<(), TomlFault> {
        let error = || TomlFault::custom(format!("`{0}` has no content: write \"{0}\"", self.name));
        ensure(self.content.is_none(), error)
    }

    fn newtype_variant_seed<T: DeserializeSeed<'de>>(self, seed: T) -> Result<T::Value, TomlFault> {
        seed.deserialize(self.require_content()?)
    }

    fn tuple_variant<V: Visitor<'de>>(self, _: usize, visitor: V) -> Result<V::Value, TomlFault> {
        self.require_content()?.deserialize_any(visitor)
    }

    fn struct_variant<V: Visitor<'de>>(self, fields: Names, visitor: V) -> Result<V::Value, TomlFault> {
        let content = self.require_content()?;
        if let DeValue::Table(table) = content.value
            && let Some((key, _)) = table.iter().find(|(key, _)| !fields.contains(&key.get_ref().as_ref()))
        {
            return Err(TomlFault::unknown_field(key.get_ref(), fields).with_span(&key.span()));
        }
        content.deserialize_any(visitor)
    }
}
