"""Campaigns: tasks, or one task in several ways, on many seeds; how often they succeed, and why not."""
