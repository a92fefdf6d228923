"""Diagnosis of machines whose days differ in everything, by a simulator that no part of the tool was tuned to."""
