"""Tables of other people's logs become bags: a column map says what each column means."""
