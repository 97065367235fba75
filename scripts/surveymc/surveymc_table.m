function t = surveymc_table(file)
% SURVEYMC_TABLE  A table that `surveymc show RESULT.h5 TABLE --csv > file` wrote, as a struct of columns.
%   t = surveymc_table("position.csv"); t.ratio(strcmp(t.quantity, "sigma3_north"))
% Numbers are column vectors (NaN where there is none), words are cell arrays; dots in names become underscores.
% For MATLAB and Octave; no toolbox and no package is needed.
  id = fopen(file, "r");
  if id < 0
    error("surveymc_table: %s: no such file", file);
  end
  close_it = onCleanup(@() fclose(id));
  names = strsplit(strtrim(fgetl(id)), ",");
  cells = textscan(id, repmat("%q", 1, numel(names)), "Delimiter", ",");
  t = struct();
  for k = 1:numel(names)
    words = cells{k};
    numbers = str2double(words);
    if all(~isnan(numbers) | strcmpi(words, "nan") | strcmp(words, ""))
      words = numbers;
    end
    t.(strrep(strrep(names{k}, '"', ""), ".", "_")) = words;
  end
end
