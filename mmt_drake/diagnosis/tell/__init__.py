"""The diagnosis as a document, a model file, a report and pictures, and what to record next."""
