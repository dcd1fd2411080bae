"""The report of a lot's use as a document that is handed over: HTML, PDF, and a workbook with the same figures."""
